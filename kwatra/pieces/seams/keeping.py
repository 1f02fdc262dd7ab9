"""Seams that are there already are kept against later ones that cost more.

Of two ways to copy a picture together each pixel takes the one or the other, along minimum cuts (thesis 3.1):

    sum over neighbors p, q of M(p, q, X_p, X_q),    X_p the earlier or the later place of p.

The sum is not one that a cut always minimizes, since both ways have seams of their own. So it is cut as if no earlier
seam cost more than what parts the later way from it, and what comes of that is taken if the seams then cost less.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from kwatra.base import shared
from kwatra.cut import FREE, KEEP, best_cut
from kwatra.pieces.seams.stock import Array, beside


class Costs(Protocol):
    """What seams cost, as of `SeamCost`."""

    def between(self, s: Array, t: Array, axis: int, axes: int) -> Array:
        """What seams cost between places of any shape, of pixels one step apart along an axis of so many."""


def cheaper(cost: Costs, before: Array, after: Array, wraps: Sequence[bool] = (), taking: Array | None = None) -> Array:
    """Where (boolean, *S) to go over from the places `before` (*S) to those `after`, so that seams cost least.

    Nowhere if no cut lowers what seams cost. wraps: along which axes the last pixel lies before the first, which then
    stays as it was. taking (*S): what a pixel costs more that goes over, whole numbers; nothing by default.
    """
    shape = before.shape
    more = np.zeros(shape, np.int64) if taking is None else taking
    for axis in np.flatnonzero(wraps).tolist():
        first = before.take([0], axis)
        before = np.concatenate([before, first], axis)
        after = np.concatenate([first, np.delete(after, 0, axis), first], axis)
        more = np.concatenate([more, np.zeros_like(more.take([0], axis))], axis)
    free = before != after
    pairs = shared(partial(_pairs, cost, before, after, free), range(free.ndim))
    take = _cut(free, pairs, more)
    lower = sum(each.rise(take) for each in pairs) + int(more[take].sum()) < 0
    return (take if lower else np.zeros_like(take))[tuple(map(slice, shape))]


class _Pairs(NamedTuple):
    """The neighbors along an axis of which either may go over, among all that indices p and q tell (*S).

    costs (4, n): of the seam between them where neither goes over, q does, p does, and both.
    """

    p: Any
    q: Any
    where: Array
    costs: Array

    def spread(self, values: Array) -> Array:
        """Values (n,) where they belong (*S), among zeros."""
        spread = np.zeros(self.where.shape, np.int32)
        spread[self.where] = values
        return spread

    def rise(self, take: Array) -> int:
        """By how much seams cost more with what is taken than before."""
        p, q = take[self.p][self.where], take[self.q][self.where]
        return int((self.costs[2 * p + q, np.arange(len(p))] - self.costs[0]).sum())


def _pairs(cost: Costs, before: Array, after: Array, free: Array, axis: int) -> _Pairs:
    """The pairs along an axis, of pixels that may go over where they are free."""
    sides = beside(axis, free.ndim)
    where = np.logical_or(*(free[side] for side in sides))
    p, q = ((before[side][where], after[side][where]) for side in sides)
    costs = [cost.between(s, t, axis, free.ndim) for s in p for t in q]
    return _Pairs(*sides, where, np.stack(costs).astype(np.int64))


def _cut(free: Array, pairs: list[_Pairs], more: Array) -> Array:
    """The cut by what pairs cost, and what pixels cost more that go over, of the pixels that are free.

    It has no cost where both sides are taken: half of what the later seam costs lies on either.
    """
    taking, costs = more.copy(), []
    for each in pairs:
        a, b, c, both = each.costs
        back = both // 2
        ahead = both - back
        taking[each.p][each.where] += ahead
        taking[each.q][each.where] += back
        costs.append((each.spread(a), each.spread(b - back), each.spread(c - ahead)))
    return best_cut(np.where(free, FREE, KEEP).astype(np.int8), costs, taking)
