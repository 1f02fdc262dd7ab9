"""The matching cost of a seam between two neighboring pixels s and t that come from patches A and B.

    M(s, t, A, B)  = |A(s) - B(s)| + |A(t) - B(t)|                                        (thesis equation 1)
    M'(s, t, A, B) = M / (|G_A(s)| + |G_A(t)| + |G_B(s)| + |G_B(t)|),  G along s -> t      (thesis equation 5)
                     times ACROSS_TIME where s -> t is a step in time

|.| is the distance of what patches are cut from, in whole numbers: M is a metric without any rounding and sums of it
are exact. M' prefers seams through busy regions, where they show less; it is no metric, and the cut then treats an old
seam as costing at most what replacing it on both sides would (kwatra.cut). Use M where the cut must be the best
possible, M' where flat and busy regions mix.

A seam is hidden where one of the two pixels that it parts, as they are then seen, shows ground between elements: what
ends there ends as elements do. So where it is known how deep in its element each place lies, a seam between A(s) and
B(t) costs

    (hidden + (1 - hidden) d) M + least d,    d the lesser depth of A(s) and B(t).

It then runs along the gaps of one side, and through elements of both nowhere, however alike their colors are. Elements
without gaps end at outlines: there d is low only where A or B passes from one part into another between s and t.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kwatra.base.axes import AXES
from kwatra.cut import Costs, best_cut, seams_after, solved_at_once
from kwatra.pieces.seams.mosaic import LEVELS, Mosaic
from kwatra.pieces.seams.prices import Prices
from kwatra.pieces.seams.stock import Array, Stock, beside

NORMALIZED_SCALE = 4096
"""What a seam of M' = 1 costs, as costs are whole numbers."""

ACROSS_TIME = 2
"""What a seam between frames costs more in M'. Each pixel passes from patch to patch in some frame; where it were as
cheap as a seam within a frame, all would pass in one, which is the smallest surface, and is seen as a flash. Quilted
smoke flickers 1.07 times as much as it should with 1, .97 times with 2 and .91 times with 4, with which it and a
fountain are softer."""

HIDDEN = 0.05
"""The part of M that a seam costs along the ground. Made stones and coins are cut as seldom with .02, and half as often
again with .2, which leaves cleaner seams in small bricks."""

FLAT = 0.02
"""Gradient, per channel and as a fraction of the color range, that a perfectly flat region is taken to have in M'."""


class Steepness(NamedTuple):
    """What M is divided by, times NORMALIZED_SCALE: least (axes,), and the slopes of A and B at s and t along the axis.

    slopes (axes, N): by place of a mosaic; (axes, 0) if they are not counted.
    """

    least: Array
    slopes: Array


class Depth(NamedTuple):
    """at: how deep in its element a place lies, 0 (ground) to 1, of many; least: what a seam costs there at least.

    hidden: the part of M that a seam costs along the ground; 1 makes only elements dearer. part: to which part each of
    many places belongs, 0 for none, of elements that meet at outlines; None of elements that are apart.
    """

    at: Callable[[Array], Array]
    least: float
    hidden: float = HIDDEN
    part: Callable[[Array], Array] | None = None

    def ending(self, places: Array, beyond: Array) -> Array:
        """How deep places lie at which a copy ends that would go on at the places beyond.

        Of elements that meet as deep as can be, but where it would go on in another part.
        """
        deep = self.at(places)
        if self.part is None:
            return deep
        part = self.part(places)
        return np.where((part == self.part(beyond)) | (part == 0), np.float32(1), deep)

    def of_seam(self, s: Array, back: Array, ahead: Array, t: Array) -> Array:
        """d of seams between places s and t of A and B; ahead, back: where A would go on beyond s, and B before t."""
        lesser: Array = np.minimum(self.ending(s, ahead), self.ending(t, back))
        return lesser


class SeamCost:
    """M between places of a stock; or M', if given what to divide by.

    depth: if it is known, seams are hidden on the ground; not together with steepness.
    """

    def __init__(self, sources: Stock, steepness: Steepness | None = None, depth: Depth | None = None):
        self.sources, self.steepness, self.depth = sources, steepness, depth

    @cached_property
    def prices(self) -> Prices:
        """The same as arrays, of a mosaic."""
        assert isinstance(self.sources, Mosaic)
        deep, parts, none = np.empty(0, np.float32), np.empty(0, np.int32), np.empty(0, np.int64)
        hidden, least = (1.0, 0.0) if self.depth is None else (self.depth.hidden, self.depth.least)
        if self.depth is not None:
            every = np.arange(self.sources.planes.shape[1])
            deep = self.depth.at(every).astype(np.float32, copy=False)
            parts = parts if self.depth.part is None else self.depth.part(every).astype(np.int32, copy=False)
        if self.steepness is None:
            return Prices(deep, parts, hidden, least, none, none, np.empty((0, 0), np.int32))
        axes = len(self.steepness.least)
        missing = [(AXES - axes, 0)]
        scales = np.pad([_scale(axis, axes) for axis in range(axes)], missing)
        divisors = np.pad(self.steepness.least, missing, constant_values=1)
        return Prices(deep, parts, hidden, least, scales, divisors, np.pad(self.steepness.slopes, [*missing, (0, 0)]))

    def pairs(self, old: Array, new: Array, remembered: Sequence[Array], choice: Array | None = None) -> list[Costs]:
        """Per axis the costs (a, b, c) of kwatra.cut between neighbors of a window; of empty pixels, anything.

        old, new: what its pixels show, and what they would show of a new patch. remembered: per axis the cost of the
        seam that is between a pixel and the next now. choice: what may happen to pixels, None for anything; where no
        seam comes to lie b and c may be anything, too.
        """
        if isinstance(self.sources, Mosaic):
            from kwatra.pieces.seams.matches import matched

            found = matched(self.sources.planes, self.sources.strides, old, new, choice, self.prices)
            return [(a, b, c) for a, (b, c) in zip(remembered, found, strict=True)]
        pairs = []
        for axis, (a, (b, c)) in enumerate(zip(remembered, self.sources.matches(old, new), strict=True)):
            p, q = beside(axis, len(remembered))
            if self.depth is not None or self.steepness is not None:
                ahead, back = self.sources.beyond(old[p], axis, 1), self.sources.beyond(old[q], axis, -1)
                b = self._priced(axis, b, (old[p], new[p], ahead, new[q]), len(remembered))
                c = self._priced(axis, c, (new[p], back, new[q], old[q]), len(remembered))
            pairs.append((a, b, c))
        return pairs

    def cut(
        self, old: Array, new: Array, remembered: Sequence[Array], choice: Array, taking: Array | None, most: int
    ) -> tuple[Array, list[Array]] | None:
        """Which pixels of a window take a patch in the cheapest cut, and per axis the seams then.

        old, new, remembered: as in `pairs`; choice, taking: as in `best_cut`. None if it is known, before it is solved,
        that all comes to over `most` more than now.
        """
        if isinstance(self.sources, Mosaic) and solved_at_once(choice):
            from kwatra.pieces.seams.matches import cut_in

            mosaic = self.sources
            return cut_in(mosaic.planes, mosaic.strides, old, new, remembered, choice, taking, self.prices, most)
        pairs = self.pairs(old, new, remembered, choice)
        take = best_cut(choice, pairs, taking)
        return take, seams_after(choice, take, pairs)

    def seam(self, s: Array, t: Array, axis: int, axes: int) -> Array:
        """The cost of seams between places s and t, those of pixels one step apart along an axis of so many."""
        ahead, back = self.sources.beyond(s, axis, 1), self.sources.beyond(t, axis, -1)
        show_s, show_t, after, before = (self.sources.colors(places) for places in (s, t, ahead, back))
        match = self.sources.distance(show_s, before) + self.sources.distance(after, show_t)
        return self._priced(axis, match, (s, back, ahead, t), axes)

    def within(self, places: Array) -> list[Array]:
        """Per axis what the seam between each pixel of some places (*S) and the next costs, 0 within a copy."""
        costs = []
        for axis in range(places.ndim):
            s, t = (places[side] for side in beside(axis, places.ndim))
            costs.append(self.between(s, t, axis, places.ndim))
        return costs

    def between(self, s: Array, t: Array, axis: int, axes: int) -> Array:
        """What seams cost between such places of any shape as `seam` has them, 0 where a copy goes on."""
        cost, parted = np.zeros(s.shape, np.int32), ~self.sources.same(self.sources.beyond(s, axis, 1), t)
        cost[parted] = self.seam(s[parted], t[parted], axis, axes)
        return cost

    def _priced(self, axis: int, match: Array, places: Sequence[Array], axes: int) -> Array:
        """What is asked for, from M and the places A(s), B(s), A(t), B(t), of which the first and the last are seen."""
        if self.depth is not None:
            depth = self.depth.of_seam(*places)
            more = np.where(self.sources.same(*places[2:]), 0, self.depth.least)  # what goes on has no seam
            hidden = self.depth.hidden
            return np.rint((hidden + (1 - hidden) * depth) * match + more * depth).astype(np.int32)
        if self.steepness is None:
            return match
        divisor, slopes = self.steepness.least[axis], self.steepness.slopes[axis]
        if slopes.size:
            divisor = divisor + sum(slopes[place] for place in places)
        return (match.astype(np.int64) * _scale(axis, axes) // divisor).astype(np.int32)


def normalized(sources: Mosaic) -> SeamCost:
    """M' of a mosaic, in which what is perfectly flat is taken to have a gradient, too."""
    flat = int(4 * FLAT * LEVELS * len(sources.planes))
    return SeamCost(sources, Steepness(np.full(sources.dims, flat), sources.slopes))


def eased(sources: Stock, easier: Sequence[float]) -> SeamCost:
    """M, so many times less along each axis (`kwatra.elements.easier`)."""
    if max(easier) == 1:
        return SeamCost(sources)
    less = np.array([round(NORMALIZED_SCALE * by) for by in easier])
    return SeamCost(sources, Steepness(less, np.empty((len(less), 0), np.int32)))


def _scale(axis: int, axes: int) -> int:
    """What M' = 1 costs along an axis of so many."""
    return NORMALIZED_SCALE * (ACROSS_TIME if axis < axes - 2 else 1)


def summed(costs: Iterable[Array]) -> int:
    """What seams cost together, given per axis."""
    return sum(int(cost.sum(dtype=np.int64)) for cost in costs)
