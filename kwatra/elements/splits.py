"""Ground that a picture's pixels are split into, and elements: how surely it is ground, and how plain."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements.contrast import RARE, ROUNDING, smoothed
from kwatra.elements.parting import Array, Variance, at_edge, usual_area
from kwatra.exemplar import Exemplar

HOLE, SPECK = 0.5, 0.04
"""Smaller parts, in areas of an element, are no ground, and no elements. This and the next two say what elements are;
they are not tuned."""

SMALL, LARGE = 0.1, 2.0
"""The areas between which a part is like an element, in squares of its size."""

MANY, COVER = 8, 0.3
"""So many elements, on so much of the picture, are enough to be sure."""

PLAIN, MIXED = 0.2, 0.22
"""Ground hides seams if its colors vary by at most PLAIN of what the picture's do, and none if by MIXED.

That of stones, coins, tiles, letters, mosaics and scales made in code, nuts and print varies by up to .20, and by .22
and more what is a texture of its own (between pavers, pebbles, holes of nuts): along it hidden seams are seen. Nine
photographs with such ground score .0587 where it hides none, .0617 with .2 and .25, .0676 with .2 and .3."""

LESS = 0.95
"""Ground of a color that is not frequent is so much less likely. That of two mosaics in 24 is likelier by a fifth than
the stones that are taken for ground else; of the others, and of stones, all are as likely within .01."""

FAR = 6.0
"""A speck beside a hole, or the border, is of an element if its color is so many times as far from the ground's as half
of that is. Not tuned."""

RIM = 0.25
"""An element is as deep as can be so far from the ground, in sizes of an element; half and twice as much is as good."""


@dataclass(frozen=True)
class Ground:
    """Where ground lies in an exemplar's canvas.

    depth (*S): 0 on the ground, and more within elements, to 1 a quarter of their size from it. sure: 0 to 1, how
    surely there is ground, and elements on it. plain: 0 to 1, how well a seam upon it is hidden, as its colors are
    alike, or beside those of elements that each have their own, or as it is a texture, and even. size: that of an
    element, in pixels. long: whether it is a net of thin lines that parts long elements, as bricks.
    """

    depth: Array
    sure: float
    plain: float
    size: float
    long: bool = False

    @property
    def hides(self) -> float:
        """How well it hides seams, 0 to 1."""
        return self.sure * self.plain


class Split(NamedTuple):
    """A way to tell ground (*S) from elements; splits of a kind are alike but for how much is ground.

    taken (*S): what of it are specks that are taken for ground. sure: as in `Ground`. merged: the share of the picture
    in parts too large to be elements. varied: the variance of its colors, as a share of the picture's.
    """

    kind: str
    ground: Array
    taken: Array
    sure: float
    merged: float
    varied: float

    @property
    def plain(self) -> float:
        """As in `Ground`."""
        return min(max((MIXED - self.varied) / (MIXED - PLAIN), 0.0), 1.0)

    @property
    def whole(self) -> float:
        """How surely it is all of the ground: what it leaves of that makes parts too large.

        By how sure it is alone .39 of five pages of letters in twelve were ground, right around rows, not .55 to .77.
        """
        return self.sure * (1 - self.merged)

    @property
    def likely(self) -> float:
        """How likely it is the ground: surely ground, all of it, and alike."""
        return self.whole * (1 - self.varied) * (LESS if self.kind.startswith(RARE) else 1)


class Picture:
    """An exemplar's colors (C, *S), and the image that each pixel belongs to, `owner` (*S), -1 for nobody's."""

    def __init__(self, exemplar: Exemplar) -> None:
        self.colors, self.owner = exemplar.canvas.double().numpy(), exemplar.owner.long().numpy()
        self.inside = self.owner >= 0
        self.variance = Variance(self.colors, self.inside)

    def judged(self, kind: str, split: Array, size: float) -> Split:
        """A split (*S) of some kind, where elements have a size."""
        ground, sure, merged = cleaned(split & self.inside, self.owner, size)
        return Split(kind, ground, ground & ~split & self.inside, sure, merged, self.variance.share(ground))

    def by_itself(self, kind: str, split: Array) -> tuple[Split, float]:
        """A split (*S) of some kind, where elements have the size that most of what it leaves has, and that size."""
        area = _areas(self.inside & ~split)
        size = float(np.sqrt(usual_area(area) * np.count_nonzero(self.inside) / max(area.sum(), 1)))
        return self.judged(kind, split, size), size

    def uneven(self, ground: Array, over: float) -> float:
        """The variance of colors of ground (*S), averaged over so many pixels of it, as a share of the picture's."""
        averaged = np.stack([smoothed(channel, ground, over) for channel in self.colors])
        return Variance(averaged, ground).total / max(self.variance.total, ROUNDING)

    def told(self, split: Split, sure: float, size: float) -> Ground:
        """A split as ground that is so sure."""
        ground = split.ground & ~_cut_off(split, self.colors, self.inside)
        return Ground(depth_beside(ground, size), sure, split.plain, size)


def cleaned(ground: Array, owner: Array, size: float) -> tuple[Array, float, float]:
    """Ground without holes in elements, and without specks upon it; and how surely it is one, 0 to 1.

    The third is the share of the picture in parts that are too large to be elements. owner (*S): the image to which
    each pixel belongs, -1 for nobody. In each of them the ground hangs together.
    """
    from kwatra.elements.partloops import clean

    cleaner, square = np.empty(owner.shape, bool), size**2
    least = HOLE * square, SPECK * square, SMALL * square, LARGE * square
    connected, like, covered, merged = clean(np.ascontiguousarray(ground), owner, *least, cleaner)
    inside = np.count_nonzero(owner >= 0)
    few = min(1.0, like / MANY) * min(1.0, covered / inside / COVER)
    return cleaner, connected * few * covered / max(covered + merged, 1), merged / max(inside, 1)


def _areas(pixels: Array) -> Array:
    """How many pixels parts of some (*S) have."""
    from kwatra.elements.partloops import part

    first, area = np.empty((2, pixels.size), np.int32)
    part(pixels, False, first, area)
    return area[area > 0]


def depth_beside(ground: Array, size: float) -> Array:
    """How deep in elements of some size pixels (*S) lie, 0 to 1, given where ground lies."""
    if not ground.any():
        return np.ones(ground.shape)
    away = ndimage.distance_transform_edt(np.pad(~ground, 1, mode="edge"))[1:-1, 1:-1]
    depth: Array = np.clip(away / max(RIM * size, 1.0), 0, 1)
    return depth


def middle_of(colors: Array) -> tuple[Array, Array]:
    """The median of colors (C, n) in each channel, and that of how far they are from it, (C,) each."""
    middle = np.median(colors, 1)
    return middle, np.median(np.abs(colors - middle[:, None]), 1)


def _cut_off(found: Split, colors: Array, inside: Array) -> Array:
    """What was taken for specks (*S), but a hole, or the border, cut it off an element: it is of another color."""
    parts, _ = ndimage.label(found.taken)
    beside, rest = at_edge(parts, inside), found.ground & ~found.taken
    if beside.size == 0 or not rest.any():
        return np.zeros(parts.shape, bool)
    middle, spread = middle_of(colors[:, rest])
    means = np.stack([ndimage.mean(channel, parts, beside) for channel in colors])
    other = np.square(means - middle[:, None]).sum(0) > FAR**2 * np.square(spread).sum()
    cut: Array = np.isin(parts, beside[other])
    return cut
