"""What renewed blocks are cut from: places between an exemplar's pixels, as `kwatra.pieces` lays them."""

from collections.abc import Callable, Sequence

import numpy as np
import torch

from flow.animation.carrying import JUMP
from flow.animation.film import Reading
from kwatra import Exemplar
from kwatra.pieces import Depth, Hidden, SeamCost
from kwatra.pieces.seams import Array, Matches, Stock, beside, eased
from kwatra.windows import channels_last

NOWHERE = -1e3
"""The source coordinates of what is not yet there: far outside any exemplar."""

COUNTS = 10_000
"""Costs are counted in whole numbers, so many to one variance of the exemplar."""

MIXING = 10.0
"""What a seam through an element costs more, in deviations of the exemplar. Of made stones of 32 px in a pair of
vortices, over frames 40 to 100 and two seeds, .50 are cut with 10 and .46 with 20, with which frames flicker by .083
for .074; with .5 two thirds of every new seam led through stones. Along gaps seams cost what they cost elsewhere: where
they are cheap, as in a first frame, chips of nuts are scattered over the ground."""

TURNS = 4096
"""Source k is the exemplar turned by k of so many parts of a whole turn: .1 px over 64. Not tuned."""

_MOST = 1000.0
"""Costs beyond so many variances are as good as infinite."""


class Coordinates(Stock):
    """An exemplar read at places (3, *S): source coordinates, x first, and the angle by which their copy is turned.

    It is read between its pixels as what is compared, not shown, needs it: bilinearly. Colors differ by their distance
    in the exemplar's deviations (variance: the mean square of one), times `cost`.
    """

    def __init__(self, exemplar: Exemplar, variance: float, cost: float) -> None:
        self._read, share = Reading(exemplar, "bilinear"), exemplar.share
        self._scale = (share / variance).sqrt().numpy().ravel()
        self._pixels = channels_last(self._read.continued).numpy() * self._scale
        self._cost = cost

    def whole(self, hidden: Hidden | None, easier: tuple[float, float]) -> SeamCost:
        """What seams between coordinates cost, more through elements where the exemplar has gaps between them.

        easier: by how many times less, where it has none (`kwatra.elements.easier`).
        """
        if hidden is None:
            return eased(self, easier)
        rows, columns = hidden.depth.shape

        def nearest(values: Array) -> Callable[[Array], Array]:
            def at(places: Array) -> Array:
                x, y = np.rint(places[:2]).astype(np.int64)
                there: Array = values[y.clip(0, rows - 1), x.clip(0, columns - 1)]
                return there

            return at

        least = MIXING * hidden.dearer * hidden.hides * self._cost * COUNTS
        part = None if hidden.parts is None else nearest(hidden.parts)
        return SeamCost(self, depth=Depth(nearest(hidden.depth), least, hidden=1.0, part=part))

    def nowhere(self, shape: tuple[int, ...]) -> Array:
        """Places for pixels that show nothing."""
        return np.stack([np.full(shape, value, np.float32) for value in (NOWHERE, NOWHERE, 0.0)])

    def places(self, number: int, lines: Sequence[Array]) -> Array:
        """The places on the grid spanned by rows and columns (fractions of a pixel) of a source."""
        y, x = np.meshgrid(*lines, indexing="ij")
        angle = number * 2 * np.pi / TURNS
        cos, sin = np.cos(angle), np.sin(angle)
        return np.stack([cos * x - sin * y, sin * x + cos * y, np.full_like(x, angle)]).astype(np.float32)

    def colors(self, places: Array) -> Array:
        """The colors at places."""
        return self._read(torch.from_numpy(np.ascontiguousarray(places[:2]))).numpy()

    def beyond(self, places: Array, axis: int, step: int) -> Array:
        """The places one step (1 or -1) along an axis of the frame: rows, then columns."""
        ahead, cos, sin = places.copy(), np.cos(places[2]), np.sin(places[2])
        across, down = (cos, sin) if axis else (-sin, cos)
        ahead[0] += step * across
        ahead[1] += step * down
        return ahead

    def same(self, one: Array, other: Array) -> Array:
        """Whether places are those of one copy, which may be bent."""
        near: Array = np.square(one[:2] - other[:2]).sum(0) < JUMP**2
        return near

    def distance(self, one: Array, other: Array) -> Array:
        """How unlike colors are, in COUNTS of a deviation times the cost."""
        scale = self._scale.reshape(-1, *[1] * (one.ndim - 1))
        return counted(self._cost * np.sqrt(np.square((one - other) * scale).sum(0)))

    def matches(self, old: Array, new: Array) -> Matches:
        """See `Stock.matches`; the same, but for rounding, in one loop."""
        from flow.animation.renewing.matching import match

        second, first = (np.empty((2, *old.shape[1:]), np.float32) for _ in range(2))
        match(self._pixels, np.ascontiguousarray(old), np.ascontiguousarray(new), self._cost, second, first)
        sides = [beside(axis, 2)[0] for axis in range(2)]
        return [(counted(second[axis][p]), counted(first[axis][p])) for axis, p in enumerate(sides)]


def counted(values: Array) -> Array:
    """Costs in variances as whole numbers."""
    return np.rint(values.clip(-_MOST, _MOST) * COUNTS).astype(np.int32)
