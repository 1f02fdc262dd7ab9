"""Seams that are there already are kept against later ones that cost more.

Of two ways to copy a picture together each pixel takes the one or the other, along minimum cuts (thesis 3.1):

    sum over neighbors p, q of M(p, q, X_p, X_q),    X_p the earlier or the later place of p.

The sum is not one that a cut always minimizes, since both ways have seams of their own. So it is cut as if no earlier
seam cost more than what parts the later way from it, and what comes of that is taken if the seams then cost less.
"""

from functools import partial

import numpy as np

from kwatra.base import shared
from kwatra.cut import FREE, KEEP, best_cut
from kwatra.pieces.seams import SeamCost
from kwatra.pieces.stock import Array, beside


def cheaper(cost: SeamCost, before: Array, after: Array) -> Array:
    """Where (boolean, *S) to go over from the places `before` (*S) to those `after`, so that seams cost least.

    Nowhere if no cut lowers what seams cost.
    """
    free = before != after
    asked = [free[p] | free[q] for p, q in (beside(axis, free.ndim) for axis in range(free.ndim))]
    costs = shared(partial(_costs, cost, before, after, asked), range(free.ndim))
    take = _cut(free, asked, costs)
    rise = sum(_rise(take, axis, *each) for axis, each in enumerate(zip(asked, costs, strict=True)))
    return take if rise < 0 else np.zeros_like(take)


def _costs(cost: SeamCost, before: Array, after: Array, asked: list[Array], axis: int) -> Array:
    """What seams cost (4, n) between those of the pairs p, q along an axis of which anything is asked.

    That is where neither goes over, q does, p does, and both.
    """
    p, q = ((before[side][asked[axis]], after[side][asked[axis]]) for side in beside(axis, before.ndim))
    return np.stack([cost.between(s, t, axis, before.ndim) for s in p for t in q]).astype(np.int64)


def _cut(free: Array, asked: list[Array], costs: list[Array]) -> Array:
    """The cut by what pairs cost; where nothing is asked it costs nothing.

    It has no cost where both sides are taken: half of what the later seam costs lies on either.
    """
    taking, pairs = np.zeros(free.shape, np.int64), []
    for axis, (where, (a, b, c, both)) in enumerate(zip(asked, costs, strict=True)):
        p, q = beside(axis, free.ndim)
        back = both // 2
        ahead = both - back
        taking[p][where] += ahead
        taking[q][where] += back
        pairs.append((_spread(where, a), _spread(where, b - back), _spread(where, c - ahead)))
    return best_cut(np.where(free, FREE, KEEP).astype(np.int8), pairs, taking)


def _spread(where: Array, values: Array) -> Array:
    """Values (n,) where they belong, among zeros."""
    spread = np.zeros(where.shape, np.int32)
    spread[where] = values
    return spread


def _rise(take: Array, axis: int, asked: Array, costs: Array) -> int:
    """By how much seams along an axis cost more with what is taken than before."""
    p, q = (take[side][asked] for side in beside(axis, take.ndim))
    return int((costs[2 * p + q, np.arange(len(p))] - costs[0]).sum())
