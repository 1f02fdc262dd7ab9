"""Seams that are there already are kept against later ones that cost more.

Of two ways to copy a picture together each pixel takes the one or the other, along minimum cuts (thesis 3.1):

    sum over neighbors p, q of M(p, q, X_p, X_q),    X_p the earlier or the later place of p.

The sum is not one that a cut always minimizes, since both ways have seams of their own. So it is cut as if no earlier
seam cost more than what parts the later way from it, and what comes of that is taken if the seams then cost less.
"""

import numpy as np

from kwatra.base import shared
from kwatra.cut import FREE, KEEP, best_cut
from kwatra.pieces.seams import SeamCost, summed
from kwatra.pieces.stock import Array, beside


def cheaper(cost: SeamCost, before: Array, after: Array) -> Array:
    """Where (boolean, *S) to go over from the places `before` (*S) to those `after`, so that seams cost least.

    Nowhere if no cut lowers what seams cost.
    """
    old, new = shared(cost.within, [before, after])
    choice, taking, pairs = np.where(before == after, KEEP, FREE).astype(np.int8), np.zeros(before.shape, np.int64), []
    for axis, (there, (a, b, c)) in enumerate(zip(new, cost.pairs(before, after, old, choice), strict=True)):
        # a cut has no cost where both sides are taken: half of what the later seam costs lies on either
        back = there.astype(np.int64) // 2
        ahead = there - back
        p, q = beside(axis, before.ndim)
        # where the later way has a seam of its own the two pixels are not of one patch, as `pairs` takes them to be
        parted = ~cost.sources.same(cost.sources.beyond(after[p], axis, 1), after[q])
        b[parted] = cost.seam(before[p][parted], after[q][parted], axis, before.ndim)
        c[parted] = cost.seam(after[p][parted], before[q][parted], axis, before.ndim)
        taking[p] += ahead
        taking[q] += back
        pairs.append((a, b - back, c - ahead))
    take = best_cut(choice, pairs, taking)
    mixed = cost.within(np.where(take, after, before))
    return take if summed(mixed) < summed(old) else np.zeros_like(take)
