"""What is known of boxes in which blocks may be laid, as compiled loops set it and read it."""

from typing import NamedTuple

from kwatra.pieces.seams import Array


class Seen(NamedTuple):
    """What is known of boxes (b,) of one extent, and what that is to the blocks (n,) that may be laid in them.

    places, known (b, A, B, C): where in a mosaic of the exemplar alone it comes from, and of which pixels it is; some
    (b,): whether any is; most (b,): of which patch most are, the first if none is. ones, against: see `take_known`.
    valid (b, n): which blocks may be laid; same (b, n): how many pixels come from where each block would have them.
    """

    places: Array
    known: Array
    some: Array
    most: Array
    ones: Array
    against: Array
    valid: Array
    same: Array


class Compared(NamedTuple):
    """How blocks (n,) compare with what is known of boxes (b,), in k images, before that is counted (`compare`).

    raw (b, k, n): their squared differences, less the energy of what is known; of no boxes where nothing is compared.
    against (b, k + 1, A, B, C): of each pixel that energy, and whether it is known. inside (b, k + 1, n): the sums of
    both over what each block shows; of no boxes where it shows all but what hangs over the image. hangs: whether any
    does; spans: of each axis the first pixels of boxes that do not with a block, and those after the last. share: what
    is not shown differs as in that block which so many of the valid ones are no worse than. scales (k,): the units;
    steps: of one, how many are told apart.
    """

    raw: Array
    against: Array
    inside: Array
    hangs: bool
    spans: tuple[tuple[Array, ...], tuple[Array, ...]]
    share: float
    scales: Array
    steps: float


class Around(NamedTuple):
    """What is shown around boxes (b,) of an image's sheet.

    places, label (H, W): what pixels show of a mosaic's `cell` (2,), and of which patch, < 0 of none. twins (t, cells):
    what is shown of each place as well, < 0 for nothing. starts, stops (b, 2): of the boxes. reach: from so many pixels
    away what is shown no longer counts. spans: of each of three axes the first places under blocks, and those after the
    last.
    """

    places: Array
    label: Array
    twins: Array
    starts: Array
    stops: Array
    reach: int
    cell: Array
    spans: tuple[tuple[Array, ...], tuple[Array, ...]]


class Charges(NamedTuple):
    """What blocks (n,) cost in boxes (b,) beside that they disagree with what is known there.

    missed (b, n): what they miss of a wish, which adds to how little they agree; of no boxes where nothing is wished.
    away (b, n): what places charge; (b, 0) for nothing. used (1, A, B, C): how often each place was; under: of each
    axis the first places under blocks, and those after the last; pixels (n,): how many each shows, size: all that there
    are; usage: what a block costs that was used once more than all on average. around: what is shown there; again,
    beside: what one costs that continues a copy, that is shown right beside. steps (b, n): what they cost out of step;
    (b, 0) for nothing; in_step: what does at most that is in step; only: whether no other may be laid. more (m, b, n):
    what else they cost.
    """

    missed: Array
    away: Array
    used: Array
    under: tuple[tuple[Array, ...], tuple[Array, ...]]
    pixels: Array
    size: int
    usage: float
    around: Around
    again: float
    beside: float
    steps: Array
    in_step: float
    only: bool
    more: Array
