"""At which resolution the optimization's start is laid, and of which blocks."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from torch import Tensor

from kwatra.base import factors_of
from kwatra.elements import (
    LOOKED_AT,
    Lattice,
    Rows,
    Slant,
    anisotropy,
    continued,
    continued_weave,
    easier,
    find_lattice,
    find_outlines,
    find_repeats,
    find_slant,
    runs_along,
    translation,
    weave_beside,
)
from kwatra.exemplar import Exemplar
from kwatra.levels import LAID_FINE
from kwatra.loop.task import Task
from kwatra.pieces import BlockStart, SlantedStart, hidden_seams
from kwatra.terms import HardPixels

LARGE = 160
"""Exemplars are halved until they have at most so many pixels across."""

LARGE_CLIP = 2**16
"""Clips are halved in space until they have at most so many pixels: laid at full resolution, waterfalls scored the same
and took ten times as long."""

FRAMES, FRAMES_IN_PLACE = 12, 6
"""Length of a video's blocks, the second where they are charged for their place, so that fewer go together. EM joins
them to longer copies: from blocks of 10 a waterfall in its place repeated 60% of what it copied in runs of 8 frames and
more, from blocks of 6 30%, at the same quality. Made rain, which has no place, repeats 6% from blocks of 6 and 40% from
blocks of 12, and loses a fifth less of its sharpness."""

USAGE, USAGE_IN_TIME = 0.5, 1.0
"""What a block costs whose pixels were used once more than all on average, the second of videos.

Eight textures score .047 with .5, median .050; .050 and .057 where use is free, .045 and .051 with 1. Of videos blocks
match where little happens: of rain made in code .90 of the sharpness is left, .89 with .35 and .93 with 2, with which
smoke flickers; but where something is wished videos are as stills: of a fountain, part of which was only to be like
what is known, .33 of the sharpness was left with 1 and .41 with .5. A clip that only translates may be used however
often: so blocks are found from which all goes on."""

SHOWN = 4.0
"""A still that shows its exemplar more than so many times, as 256 pixels a side do one of 128, counts use by how often
that is: else small differences decide what is laid where it is large. Of 512 pixels a side six textures score
.0554 in place of .0596, and of made stones, coins and letters of 20 and 32 pixels .158 are cut in place of .207."""

LEAST = 8
"""Blocks are at least so many pixels wide, or as wide as the exemplar: smaller ones are thousands."""


FIBROUS, NARROW, NARROWEST = 2.2, 0.75, 8.0
"""A still runs along an axis where it changes so many times as fast across as along (`anisotropy`): its blocks are then
narrower by the root of that times the second, up to the third. Few lines go on beyond a block's end, and the narrower
it is the fewer have to; but the less of what is large is kept. Two woods and brushed metal made in code (9, 16 and 36),
320 pixels a side, two seeds, score .055, .089 and .108, and their steepest rows across are 1.10, 1.40 and 1.73 times
the exemplars'; with twice as narrow blocks, and seams that cost the same along lines as across (`easier`), .063, .096
and .123, and 1.18, 1.51 and 1.84; with blocks 1.5 times as wide .052, .078 and .089, but 1.26, 1.63 and 1.51, and ends
are seen as lines. Bricks, which reach 2.1, score .01 worse with half the width."""


OBLIQUE = 4.0
"""Lines run obliquely in a still that changes so many times as fast across as along them. In 52 photographs and made
textures it does by 2.14 at most, in two made woods and brushed metal, turned by 0 to 65 degrees, by 11 to 15."""


TALL = 1.5
"""Blocks of a scene that lie beside each other are out of step where its frames are more than so many times as high as
its clip's. At twice its size flames ended along one line across else, in all frames; five clips, judged as compressed
films, score .108 with it, .109 without (smoke .096 and .086, the others less with it). Half as large again smoke, a
waterfall and flames score .007 more so. Of what may lie anywhere all blocks agree: rain and drifting noise, 2.5 times
as large, score .152 without (two seeds each) and .154 with it."""


class Laid(NamedTuple):
    """A source map (n, *S) of copied blocks, its resolution, and the blocks."""

    where: Tensor
    factors: tuple[int, ...]
    blocks: BlockStart | SlantedStart


def block_start(task: Task, exemplar: Exemplar, draft: bool = False) -> Laid:
    """Copied blocks, at the finest resolution at which laying them costs little.

    Blocks agree with what the terms want; a mask only hides that, blocks run on behind it. draft: as in `BlockStart`.
    """
    settings, axes = task.settings, len(task.shape)
    factor, steps = _resolution(exemplar, max(level.factor for level in task.levels))
    factors, grain = factors_of(factor, axes), factors_of(steps, axes)
    here, controls = exemplar.coarser(factors), task.controls(factors)
    in_place = bool(controls.place_charges(here, (1,) * axes))
    frames = FRAMES_IN_PLACE if in_place else FRAMES
    size, along = block_size(here, controls.shape, settings.block, grain, frames), None
    given = controls.copied() if task.start == "aligned" else None
    in_step = given is None or _begins(given, here) is not None
    repeats = _repeats(task, exemplar, factor) if in_step else None
    wish = controls.wish(None if given is None else (given >= 0).all(0))
    usage = settings.even * _usage(exemplar, task.shape, wish is not None)
    seen, _ = exemplar.halved_to(LAID_FINE)
    slant = None if isinstance(repeats, Lattice) else _slant(task, seen)
    if slant is not None:
        slanted = _slanted_start(task, here, controls.shape, slant, size, grain, usage)
        return Laid(slanted.run(draft), factors, slanted)
    if axes == 2 and not isinstance(repeats, Lattice):
        size, along = narrowed(size, anisotropy(seen), grain)
    elif in_place and axes > 2 and controls.shape[1] > TALL * here.extent[1]:
        along = 1
    blocks = BlockStart(
        here,
        controls.shape,
        size,
        grain,
        task.generator,
        wraps=task.wraps,
        usage=usage,
        seams=settings.seams,
        aligned=task.start == "aligned",
        repeats=repeats,
        along=along,
        easier=(1.0,) * axes if along is None or axes > 2 else easier(anisotropy(here), along),
        places=[charge for _, charge in controls.place_charges(here, size)],
        wish=wish,
        given=given,
    )
    return Laid(blocks.run(draft), factors, blocks)


def _resolution(exemplar: Exemplar, coarsest: int) -> tuple[int, int]:
    """How much coarser than the output blocks are laid, and of how many pixels then what their offsets are multiples.

    coarsest: the factor of the coarsest level. Where all that follows is at full resolution, so they are laid, or at
    the finest one at which a still has `LAID_FINE` pixels; else every level can represent them exactly.
    """
    if coarsest == 1:
        return exemplar.halved_to(LAID_FINE)[1], 1
    factor = 1
    while factor < coarsest and _is_large(exemplar.extent, factor):
        factor *= 2
    return factor, coarsest // factor


def _begins(given: Tensor, exemplar: Exemplar) -> list[int] | None:
    """Where on the canvas an output begins, if what is given of it, from places (n, *S), is one part of the exemplar.

    None if it is none, several, or of nobody's pixels.
    """
    some = (given >= 0).all(0)
    places = given[:, some]
    firsts = (places - some.nonzero().T).unique(dim=1).T.tolist()
    return firsts[0] if len(firsts) == 1 and bool((exemplar.owner[tuple(places)] >= 0).all()) else None


def _unsteered(task: Task, given: bool = False) -> bool:
    """Whether a still is begun that nothing steers; given: or nothing but pixels that are copied from the exemplar."""
    terms = [term for term in task.terms if not (given and isinstance(term, HardPixels) and term.all_copied)]
    return task.start == "aligned" and len(task.shape) == 2 and not terms


def _slant(task: Task, exemplar: Exemplar) -> Slant | None:
    """How the lines of a single image run, None if not obliquely, or if an output wraps or is steered."""
    if not _unsteered(task) or any(task.wraps) or int(exemplar.owner.max()) > 0:
        return None
    slant = find_slant(exemplar)
    return slant if slant.aside and slant.anisotropy >= OBLIQUE else None


def _slanted_start(
    task: Task,
    here: Exemplar,
    shape: Sequence[int],
    slant: Slant,
    size: tuple[int, ...],
    grain: Sequence[int],
    usage: float,
) -> SlantedStart:
    """The start of a still whose lines run obliquely, of blocks as of one whose lines run along an axis."""
    much = slant.anisotropy if slant.along == 0 else 1 / slant.anisotropy
    return SlantedStart(
        slant,
        here,
        shape,
        narrowed(size, much, grain)[0],
        grain,
        task.generator,
        usage=usage,
        seams=task.settings.seams,
        easier=easier(much, slant.along),
    )


def _usage(exemplar: Exemplar, shape: Sequence[int], wished: bool) -> float:
    """What a block costs whose pixels were used once more than all on average in an output of some shape.

    wished: whether terms want something.
    """
    if len(shape) == 2:
        shown = math.prod(shape) / int((exemplar.owner >= 0).sum())
        return USAGE * min(SHOWN / shown, 1.0)
    if wished:
        return USAGE
    return 0.0 if translation(exemplar) else USAGE_IN_TIME


def _is_large(extent: tuple[int, ...], factor: int) -> bool:
    """Whether laying blocks takes long of an exemplar of this extent, a factor coarser."""
    if len(extent) > 2:
        return math.prod(extent) / factor**2 > LARGE_CLIP
    return min(extent) / factor > LARGE


def looks(exemplar: Exemplar) -> list[Callable[[], object]]:
    """What finds in an exemplar what is looked for where blocks of it are laid that nothing steers, each kept.

    What takes longest comes first; what part of that may ask for comes last: outlines, where no ground hides seams.
    """
    seen = exemplar.halved_to(LAID_FINE)[0]
    ways = partial(hidden_seams, seen), partial(find_slant, seen), partial(find_repeats, exemplar)
    return [*ways, partial(find_outlines, seen)]


def _repeats(task: Task, exemplar: Exemplar, factor: int) -> Lattice | Rows | None:
    """The lattice of a single image, a factor coarser, or else its rows; None where terms decide.

    Offsets from one image into another say nothing of them.
    """
    if int(exemplar.owner.max()) > 0 or not _unsteered(task, given=True):
        return None
    found = find_repeats(exemplar)
    if isinstance(found, Rows):
        found = found.closed(task.shape, task.wraps)
    return None if found is None else found.coarser(factor)


def repeated(task: Task, exemplar: Exemplar) -> Tensor | None:
    """The source map (2, *shape), at full resolution, of a picture that goes on by itself: periodic exactly, or woven.

    None where it does not, or is to be something else; what has a lattice is laid in step with it though it be woven.
    Where a part of a periodic picture is given the map goes on from that.
    """
    fine = any(level.factor == 1 for level in task.levels)
    if not fine or not _unsteered(task, given=True):
        return None
    given = task.controls((1, 1)).copied()
    if given is not None:
        first = _begins(given, exemplar)
        return None if first is None else continued(exemplar, task.shape, first)
    weave = weave_beside(find_lattice(exemplar) if exemplar.owner.numel() <= LOOKED_AT else None, exemplar)
    if weave is not None:
        return continued_weave(exemplar, weave, task.shape, task.wraps, task.generator)
    return None if any(task.wraps) else continued(exemplar, task.shape)


def block_size(
    exemplar: Exemplar, shape: Sequence[int], share: float, grain: Sequence[int], frames: int = FRAMES
) -> tuple[int, ...]:
    """Size of the blocks: `share` of the exemplar's extent, at most half of the output, a multiple of grain.

    In time, which has no grain, they are so many `frames` long, or `share` of a short clip.
    """
    size = [min(frames, max(round(share * exemplar.extent[0]), 1), shape[0])] if len(shape) > 2 else []
    for there, here, g in zip(exemplar.extent[-2:], shape[-2:], grain[-2:], strict=True):
        wanted = max(min(share * there, here / 2), LEAST)
        size.append(min(max(round(wanted / g) * g, g), there // g * g or there))
    return tuple(size)


def narrowed(size: tuple[int, ...], anisotropy: float, grain: Sequence[int]) -> tuple[tuple[int, ...], int | None]:
    """The size of a still's blocks (h, w), narrower where it runs along an axis, and that axis, None if it does not."""
    along = runs_along(anisotropy, FIBROUS)
    if along is None:
        return size, None
    much = max(anisotropy, 1 / anisotropy) if anisotropy > 0 else math.inf
    sides, g = list(size), grain[1 - along]
    width = max(sides[1 - along] / min(NARROW * math.sqrt(much), NARROWEST), LEAST)
    sides[1 - along] = min(max(round(width / g) * g, g), sides[1 - along])
    return tuple(sides), along
