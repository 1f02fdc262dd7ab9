"""Cloth whose lines run through: pictures that are a function of the row plus one of the column, as tartans are.

Blocks of one, laid side by side, tear lines wherever two of them do not meet. What is known of a row holds all along
it, so rows and columns are continued each by themselves: no line ends, whatever the periods are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from kwatra.base import by_one_thread
from kwatra.elements.kept import kept
from kwatra.elements.lattice import Lattice
from kwatra.elements.repeating import LOOKED_AT
from kwatra.exemplar import Exemplar

WOVEN, CROSSED = 0.85, 0.1
"""Rows and columns explain so much of a picture's variance, and each alone so much, or it is no such cloth. Of 64
photographs and made textures a tartan has .996 and .44; others .66 and .02 at most (bricks), or .46 and .22 (roof
tiles). Stripes that cross nothing are laid as what runs along an axis. Made tiles with joints and tones of their own
have up to .84 where these differ much; in straight rows few tiles would be seen again and again."""

CERTAIN = 0.78
"""A lattice that is so regular is one, whatever lines say. Of 92 made tartans of .7 to 2.4 periods six have a false
one, of .62 to .77 and .87; the lattices of tiles with tones of their own have .79 and more."""

JOINED = 0.05
"""Lines join where those that come to lie side by side differ by so much of their variance at most from those that did.
A ramp, which joins nowhere, has .5 and more."""

REPEATS, SHORTEST = 0.25, 0.5
"""A period is seen if so much of the exemplar repeats it; where none is, so much of it at least is shown on end."""

UNLIKE, SLIGHT = 0.5, 0.01
"""Lines that differ by so much of their variance are unlike; periods by which they differ by so much more are as good:
of 12.5 px the double fits to the pixel."""

GIVE = 0.35
"""So many lines at most, as a part of all, are left out or shown twice in an output that has to tile."""

SAME, STRETCH = 0.005, 8
"""Lines that differ by no more than so much of their variance look the same; others of them are shown each so many
lines, on average. One tartan, four seeds: the same by eye; of what is copied at a time .11 of the exemplar are left in
place of .78, .37 with .002 and .06 with half as many lines."""

TURNS = 100
"""So many turns at most find rows and columns beside each other: where all is known one does."""

SHORT = 0.05
"""What it counts if no more than nothing of the exemplar is shown on end, in the measure of JOINED."""


class Cell(NamedTuple):
    """Lines of an axis that go on with the first of them again: first and length, in pixels."""

    first: int
    length: int


class Weave(NamedTuple):
    """What is known of woven rows and columns: a cell of each, and which of all lines look the same, (n, n) each."""

    cells: tuple[Cell, Cell]
    alike: tuple[Tensor, Tensor]


@kept
@by_one_thread()  # which sums in one order
def find_weave(exemplar: Exemplar) -> Weave | None:
    """The rows and columns of an exemplar that go on for ever, None if it is not woven, or none of them join.

    An exemplar is of one image without holes. A large one is woven where it is so of fewer pixels, too.
    """
    if exemplar.owner.ndim != 2 or bool((exemplar.owner != 0).any()):
        return None
    few = exemplar.halved_to(LOOKED_AT)[0]
    if few is not exemplar and _lines(few) is None:
        return None
    lines = _lines(exemplar)
    if lines is None:
        return None
    image = exemplar.canvas * exemplar.share.sqrt()
    down, across = (_cell(each.T) for each in lines)
    if down is None or across is None:
        return None
    return Weave((down, across), (_alike(image.movedim(1, 0)), _alike(image.movedim(2, 0))))


def _lines(exemplar: Exemplar) -> tuple[Tensor, Tensor] | None:
    """The rows and columns through all of an exemplar, see `lines_through`."""
    return lines_through(exemplar.canvas * exemplar.share.sqrt(), torch.ones(exemplar.shape, dtype=torch.bool))


@by_one_thread()  # which sums in one order
def lines_through(image: Tensor, known: Tensor) -> tuple[Tensor, Tensor] | None:
    """Rows (C, H) and columns (C, W), float64, whose sums are nearest to an image (C, H, W) where it is known (H, W).

    None if they do not explain enough of it, or if nothing is known of one. Their least squares are found in turns.
    """
    image, there = torch.where(known, image, 0.0).double(), known.double()
    if not bool(known.any(0).all() & known.any(1).all()):
        return None
    rows, columns = image.new_zeros(*image.shape[:2], 1), image.new_zeros(len(image), 1, image.shape[2])
    for _ in range(TURNS):
        rows = ((image - columns) * there).sum(2, keepdim=True) / there.sum(1, keepdim=True)
        before, columns = columns, ((image - rows) * there).sum(1, keepdim=True) / there.sum(0)
        if float((columns - before).abs().max()) < 1e-6:
            break
    total, left, down, across = (
        float(((part - (part * there).sum((1, 2), keepdim=True) / there.sum()) * there).square().sum())
        for part in (image, image - rows - columns, rows, columns)
    )
    if left > (1 - WOVEN) * total or min(down, across) < CROSSED * total or total == 0:
        return None
    return rows[..., 0], columns[:, 0]


def continued_weave(
    exemplar: Exemplar,
    weave: Weave,
    shape: Sequence[int],
    wraps: Sequence[bool],
    generator: torch.Generator,
) -> Tensor | None:
    """The source map (2, *shape) of an exemplar continued line by line from the cells of its weave.

    Where lines look the same any of them is shown, so that no flaw is seen again in each cell. Where an output wraps
    (per axis) it has whole cells, of which lines are left out or shown again, evenly, to fill it; None where that are
    over GIVE of them.
    """
    lines = list[Tensor]()
    for (first, length), alike, size, wrap in zip(*weave, shape, wraps, strict=True):
        line = torch.arange(size)
        if wrap:
            filled = max(round(size / length), 1) * length
            if abs(filled - size) > GIVE * size:
                return None
            line = line * filled // size
        lines.append(_varied(first + line % length, alike, generator))
    return torch.stack(torch.meshgrid(*lines, indexing="ij")).to(exemplar.canvas.device)


def weave_beside(lattice: Lattice | None, exemplar: Exemplar) -> Weave | None:
    """The weave of an exemplar, unless its lattice, if any, is to be believed instead: what has one repeats by it."""
    weave = find_weave(exemplar)
    return None if weave is not None and lattice is not None and in_step(weave, lattice) else weave


def in_step(weave: Weave, lattice: Lattice) -> bool:
    """Whether a lattice is to be believed: it is regular, or a move by a cell, down or right, is in step with it."""
    moves = torch.diag(torch.tensor([cell.length for cell in weave.cells], dtype=torch.float64))
    return lattice.regularity >= CERTAIN or bool((lattice.rest(moves).norm(dim=0) <= 1).all())


def _alike(lines: Tensor) -> Tensor:
    """Which lines (n, C, pixels) look the same, (n, n); found from inner products, as there may be many pixels."""
    lines = lines.flatten(1).float()
    lines = lines - lines.mean(0)
    length = lines.square().sum(1)
    apart = length + length[:, None] - 2 * lines @ lines.T
    return (apart <= SAME * 2 * length.mean()) | torch.eye(len(lines), dtype=torch.bool)


def _varied(lines: Tensor, alike: Tensor, generator: torch.Generator) -> Tensor:
    """Lines (n,) to show in place of others, for some on end: each looks the same, and so does the one before it."""
    luck = torch.rand(len(lines), 2, generator=generator, dtype=torch.float64).tolist()
    shown, aside, before = list[int](), 0, int(lines[0])
    ways = [set((like.nonzero()[:, 0] - line).tolist()) for line, like in enumerate(alike)]  # 0 is in each
    for line, (new, which) in zip(lines.tolist(), luck, strict=True):
        if new * STRETCH < 1 or aside not in ways[line]:
            fit = sorted(ways[line] & ways[before])
            aside = fit[int(which * len(fit))]
        shown.append(line + aside)
        before = line
    return torch.tensor(shown)


def _cell(lines: Tensor) -> Cell | None:
    """Which lines (n, C) go on with the first of them: a period that is seen, or all, or as many as join, or None.

    All do if the last and the first differ by no more than lines that lie side by side: most pictures that show one
    period tile. After line p comes line q where lines p + 1 and q - 1 did: what is there differs by
    (|p - (q - 1)|^2 + |(p + 1) - q|^2) / 2; of lines beyond the border p and q are compared themselves.
    """
    count = len(lines)
    variance = (lines - lines.mean(0)).square().sum(1).mean()
    apart = torch.cdist(lines, lines, compute_mode="donot_use_mm_for_euclid_dist").square() / (2 * variance)
    period = _period(apart)
    if period is not None:
        near = apart.diagonal(period)
        joins = near + near.roll(1)
        first = 1 + int(joins[1:].argmin()) if len(joins) > 1 else 0
        return Cell(first, period)
    if float(apart[0, -1]) <= float(apart.diagonal(1).max()):
        return Cell(0, count)
    before, after = torch.cat([apart[:1], apart[:-1]]), torch.cat([apart[:, 1:], apart[:, -1:]], 1)
    join = (before + after) / 2  # of the last line, by column, and the first, by row
    length = torch.arange(count) - torch.arange(count)[:, None] + 1
    cost = join + SHORT * (1 - length / count)
    cost[(join > JOINED) | (length < count * SHORTEST)] = torch.inf
    first, last = divmod(int(cost.argmin()), count)
    return Cell(first, last - first + 1) if bool(cost.isfinite().any()) else None


def _period(apart: Tensor) -> int | None:
    """The shortest of the periods by which lines differ least, given how far any two are apart; None if none is seen.

    Up to where lines first differ much they are alike because they are neighbors.
    """
    count = len(apart)
    moved = torch.stack([apart.diagonal(t).mean() for t in range(int(count * (1 - REPEATS)) + 1)])
    differing = (moved > UNLIKE).nonzero()[:, 0]
    after = moved[int(differing[0]) :] if len(differing) else moved[:0]
    if not len(after) or float(after.min()) > JOINED:
        return None
    good = after <= min(float(after.min()) + SLIGHT, JOINED)
    return int(differing[0]) + int(good.nonzero()[0])
