"""Resolutions and window sizes, coarse to fine and large to small (thesis section 5.4), and the rule that picks them.

A level pairs a resolution (pixels `factor` times coarser than the output's) with a window width. A coarse level pays
only while the texture's detail survives there; which ones do follows from an estimate of the texture element.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from kwatra.base import InputError, factors_of
from kwatra.elements import element_size
from kwatra.elements.size import LOOKED_AT
from kwatra.exemplar import ALIGNMENT, Exemplar
from kwatra.source import ROUTES

FINISHING = 2
"""Iterations after blocks laid at full resolution; four changed no score by more than .0003 on eight textures."""

LAID_FINE = LOOKED_AT
"""A larger still is halved until it has so many pixels, and its blocks are laid there, where all is looked for: one of
1024 pixels a side, of as many, takes 3.8 s, and 11 where they are laid at full resolution. Of 1024 to 768 pixels three
photographs score .0137, .0135 at full resolution (`kwatra.measure`), and of six made textures with elements of 40 to
100 pixels .025 are cut, .028 there; but of 640 with elements of 14 to 20 .036, .024 there, and of 400 pixels of 512
four photographs score .054, .050 there."""

DEPTH = 4
"""Frames of a video's window (thesis 5.5: about 4)."""

FEWEST = 64
"""A level needs at least so many windows to choose from: a guard, not tuned."""


@dataclass(frozen=True)
class Level:
    """One stage of the optimization.

    factor: 1, 2, 4 or 8, how much coarser than the output. width: window width in this level's pixels, >= 2.
    iterations: at most so many EM iterations. depth: window width in time, for videos (time is never subsampled:
    thesis 5.5). route: how matches are searched, one of `kwatra.source.ROUTES`; None leaves it to the sizes.
    """

    factor: int
    width: int
    iterations: int = 4
    depth: int = 4
    route: str | None = None

    def __post_init__(self) -> None:
        if self.factor not in (1, 2, 4, 8) or self.factor > ALIGNMENT:
            raise InputError(f"a level's factor is {self.factor}; allowed are 1, 2, 4 and 8")
        if self.width < 2 or self.depth < 1 or self.iterations < 1:
            raise InputError(
                f"a level has width {self.width}, depth {self.depth}, {self.iterations} iterations; give a width of "
                "at least 2 and at least 1 of the others"
            )
        if self.route not in (None, *ROUTES):
            raise InputError(f"a level's route is {self.route!r}; allowed are {', '.join(ROUTES)} or None")

    def factors(self, axes: int) -> tuple[int, ...]:
        """The factor per axis: time, the first of three axes, keeps its resolution."""
        return factors_of(self.factor, axes)

    def window(self, axes: int) -> tuple[int, ...]:
        """The window's width per axis."""
        return (*(self.depth,) * (axes - 2), self.width, self.width)


THESIS = (Level(4, 8), Level(2, 16), Level(2, 8), Level(1, 32), Level(1, 16), Level(1, 8))
"""The levels of thesis figure 23: resolutions 1/4, 1/2, 1 with windows of 32, 16, 8 where they fit."""


def planned_levels(exemplar: Exemplar, shape: Sequence[int], iterations: int) -> tuple[Level, ...]:
    """Levels that suit an exemplar and an output of spatial `shape`.

    The coarsest resolution is the one at which exemplar and output still have 24 pixels, at most 1/4 (1/8 where the
    element spans 64 pixels or more). Its window spans the texture element, within 8 to 16 pixels; the finer resolutions
    mend what is left with 16 and 8. Windows that hardly fit between the exemplar's holes are left out. Of videos each
    resolution has one window, `DEPTH` frames deep, and half the iterations: time is never subsampled (thesis 5.5).
    """
    extent = exemplar.extent
    for name, (height, width) in (("exemplar", extent[-2:]), ("output", shape[-2:])):
        if min(height, width) < 4:
            raise InputError(f"the {name} is {width}x{height} pixels; at least 4x4 are needed")
    least = min(*extent[-2:], *shape[-2:])
    element = element_size(exemplar)
    if len(shape) > 2:
        return _between_holes(exemplar, _planned_in_time(extent, shape, element, iterations))
    coarsest = 8 if element >= 64 else 4
    factors = [f for f in (8, 4, 2, 1) if f <= coarsest and (f == 1 or least >= 24 * f)]
    levels = []
    for factor in factors:
        if factor == max(factors) and factor > 1:
            widths = [min(max(round(element / factor / 4) * 4, 8), 16)]
        else:
            widths = [16, 8]
        fit = [w for w in widths if w <= least // factor] or [min(least // factor, 8)]
        levels += [Level(factor, w, iterations) for w in fit]
    return _between_holes(exemplar, levels)


def _planned_in_time(extent: Sequence[int], shape: Sequence[int], element: float, iterations: int) -> list[Level]:
    """A video's levels: up to three resolutions, windows of 8 pixels, at the coarsest of as many as an element has."""
    least, depth = min(*extent[-2:], *shape[-2:]), min(DEPTH, extent[0], shape[0])
    factors = [f for f in (4, 2, 1) if f == 1 or least >= 24 * f]
    levels = []
    for factor in factors:
        widest = min(max(round(element / factor / 4) * 4, 8), 16) if factor == factors[0] > 1 else 8
        width = widest if widest <= least // factor else min(least // factor, 8)
        levels.append(Level(factor, width, max(iterations // 2, 1), depth))
    return levels


def finishing(levels: Sequence[Level]) -> tuple[Level, ...]:
    """What planned levels leave to do after blocks that were laid at full resolution: the last, at most twice.

    Coarser levels and larger windows then undo more seams than they mend: without them eight textures scored the same
    with a quarter less copied, and five of larger elements a sixth better, at half the cost.
    """
    return (replace(levels[-1], iterations=min(levels[-1].iterations, FINISHING)),)


def _between_holes(exemplar: Exemplar, levels: Sequence[Level]) -> tuple[Level, ...]:
    """The levels of whose windows enough fit between an exemplar's holes; or else the largest window that fits."""
    if bool((exemplar.owner >= 0).all()):
        return tuple(levels)
    axes = len(exemplar.shape)

    def count(level: Level) -> int:
        return int(exemplar.coarser(level.factors(axes)).corners(level.window(axes)).sum())

    small = [replace(levels[-1], factor=1, width=width) for width in range(levels[-1].width, 2, -2)]
    kept = [level for level in levels if count(level) >= FEWEST] or [level for level in small if count(level)][:1]
    if not kept:
        raise InputError("no 4x4 window fits between the exemplar's holes; they leave too little to copy from")
    return tuple(kept)
