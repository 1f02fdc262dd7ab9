"""Patch fitting by minimum cut (thesis section 3.1), in any number of dimensions.

Every pixel either keeps its old patch (0) or takes the new one (1). A pair of neighbors (s, t) costs

    keep, keep: a = M(s, t, A_s, A_t)     an old seam remembered (0 where both come from one patch)
    keep, take: b = M(s, t, A_s, B)       take, keep: c = M(s, t, B, A_t)       take, take: 0

The thesis hangs a seam node between s and t, with arcs b and c to the pixels and a to the new patch. Here that node is
eliminated: the same minimum is reached by arcs s -> t and t -> s that sum to b + c - a, and the rest on the arcs to the
terminals; one node and two arcs fewer per old seam. With a metric, b + c >= a always. With the cost M' it may fail, and
then a counts as b + c in the cut, which is just what the seam node does; an accepted cut still never costs more than
keeping everything. Constraint arcs are nodes that are not free: their choice is folded into their neighbors' terminals.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kwatra.cut.bands import along, solve_in_bands

KEEP, TAKE, FREE, VOID = 0, 1, 2, 3
"""What may happen to a pixel: it keeps its patch, takes the new one, may do either, or is empty and stays so."""

MOST_AT_ONCE = 100_000
"""Cuts over more free pixels than this are solved coarse to fine (coarsecut.py): faster, and bounded in memory. In
three dimensions a third of it is the limit, for there a flow takes far longer."""

Costs = tuple[np.ndarray, np.ndarray, np.ndarray]


def best_cut(
    choice: np.ndarray,
    pairs: Sequence[Costs],
    taking: np.ndarray | None = None,
) -> np.ndarray:
    """Which pixels take the new patch in the cheapest labeling; boolean, shaped as `choice`.

    `choice`: KEEP, TAKE, FREE or VOID per pixel. `pairs`: per axis the integer costs (a, b, c) of the pairs
    (p, p + 1 along the axis), one shorter than `choice` along that axis. `taking`: what a pixel costs more when it
    takes than when it keeps, integer, shaped as `choice`. Of several cheapest labelings the one that takes fewest
    pixels.
    """
    free = choice == FREE
    unary, arcs = _energy(choice, pairs)
    if taking is not None:
        unary += taking
    take = choice == TAKE
    if (unary[free] < 0).any():
        most = MOST_AT_ONCE if choice.ndim < 3 else MOST_AT_ONCE // 3
        take[free] = solve_in_bands(unary, arcs, free, _solve, most)
    return take


def seams_after(choice: np.ndarray, take: np.ndarray, pairs: Sequence[Costs]) -> list[np.ndarray]:
    """The cost of each pair, per axis, once the pixels in `take` have taken the new patch."""
    result = []
    for axis, (a, b, c) in enumerate(pairs):
        p, q = along(axis, None, -1, choice.ndim), along(axis, 1, None, choice.ndim)
        filled = (choice != VOID)[p] & (choice != VOID)[q]
        cost = np.where(take[p], np.where(take[q], 0, c), np.where(take[q], b, a))
        result.append(np.where(filled, cost, 0).astype(np.int32))
    return result


def _energy(choice: np.ndarray, pairs: Sequence[Costs]) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Terminal weights (cost of taking minus cost of keeping) and, per axis, the arcs p -> q and q -> p."""
    unary = np.zeros(choice.shape, np.int64)
    arcs = []
    for axis, (a, b, c) in enumerate(pairs):
        p, q = along(axis, None, -1, choice.ndim), along(axis, 1, None, choice.ndim)
        sp, sq = choice[p], choice[q]
        fp, fq = sp == FREE, sq == FREE
        both = fp & fq
        old = np.minimum(a, b + c)
        # Any split of -a between the two terminals is exact; the even one leaves the smallest flow to be found.
        up = np.clip(-(old // 2), -b, c - old)
        uq = -old - up
        unary[p] += np.where(both, up, np.where(fp & (sq == KEEP), c - a, np.where(fp & (sq == TAKE), -b, 0)))
        unary[q] += np.where(both, uq, np.where(fq & (sp == KEEP), b - a, np.where(fq & (sp == TAKE), -c, 0)))
        arcs.append((np.where(both, b - old - uq, 0), np.where(both, c - old - up, 0)))
    return unary, arcs


def _slots(values: np.ndarray, axis: int, forward: bool, shape: tuple[int, ...]) -> np.ndarray:
    """Pair values along an axis as one value per pixel: the pair ahead of it, or the pair behind it."""
    whole = np.zeros(shape, values.dtype)
    whole[along(axis, None, -1, len(shape)) if forward else along(axis, 1, None, len(shape))] = values
    return whole


def _neighbor_table(arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Per free pixel its arcs: capacities, and the free pixels they lead to, -1 for none; (pixels, 2 axes) each.

    Directions are back along the axes in order, then ahead in reverse order: direction d leads back as 2 axes - 1 - d.
    """
    node = np.full(free.shape, -1, np.int32)
    node[free] = np.arange(np.count_nonzero(free), dtype=np.int32)
    capacity, neighbor = [], []
    order = [(axis, False) for axis in range(free.ndim)] + [(axis, True) for axis in reversed(range(free.ndim))]
    for axis, forward in order:
        ahead, back = arcs[axis]
        other = np.take(node, range(1, free.shape[axis]) if forward else range(free.shape[axis] - 1), axis)
        other = np.where((ahead > 0) | (back > 0), other, -1)
        capacity.append(_slots(ahead if forward else back, axis, forward, free.shape)[free])
        neighbor.append(_slots(other + 1, axis, forward, free.shape)[free] - 1)
    return np.stack(capacity, 1), np.stack(neighbor, 1)


def _solve(unary: np.ndarray, arcs: Sequence[tuple[np.ndarray, np.ndarray]], free: np.ndarray) -> np.ndarray:
    """Which of the free pixels take the new patch: they lie on its terminal's side of the minimum cut."""
    from kwatra.cut.flow import sink_side  # compiled: only where a cut is solved

    capacity, neighbor = _neighbor_table(arcs, free)
    return sink_side(unary[free], capacity, neighbor, np.arange(2 * free.ndim)[::-1].copy())
