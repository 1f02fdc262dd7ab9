"""The network of a minimum cut, and the seams that are left after it: loops over the pairs of a grid, compiled.

Arrays are seen as (before, along, behind): what lies before an axis, the axis, what lies behind it. So one loop serves
any axis of any number of dimensions.

This module is compiled by numba when first used, so it is imported where a cut is solved.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.cut.choices import FREE, KEEP, TAKE, VOID

Array = np.ndarray[Any, Any]


def energy(choice: Array, pairs: Sequence[tuple[Array, Array, Array]]) -> tuple[Array, list[tuple[Array, Array]]]:
    """Terminal weights (cost of taking minus cost of keeping) and, per axis, the arcs p -> q and q -> p.

    choice, pairs: as in `best_cut`.
    """
    choice, weight = choice.astype(np.int8), np.zeros(choice.shape, np.int64)
    arcs = []
    for axis, (a, b, c) in enumerate(pairs):
        ahead, back = np.empty(a.shape, np.int64), np.empty(a.shape, np.int64)
        _priced(*(lines(v, axis) for v in (choice, a, b, c, weight, ahead, back)))
        arcs.append((ahead, back))
    return weight, arcs


def table(arcs: Sequence[tuple[Array, Array]], free: Array) -> tuple[Array, Array]:
    """Per free pixel its arcs: capacities, and the free pixels they lead to, -1 for none; (pixels, 2 axes) each.

    Directions are back along the axes in order, then ahead in reverse order: direction d leads back as 2 axes - 1 - d.
    """
    node = np.full(free.shape, -1, np.int32)
    node[free] = np.arange(np.count_nonzero(free), dtype=np.int32)
    capacity = np.zeros((np.count_nonzero(free), 2 * free.ndim), np.int64)
    neighbor = np.full(capacity.shape, -1, np.int32)
    for axis, (ahead, back) in enumerate(arcs):
        nodes, one, other = (lines(v, axis) for v in (node, ahead, back))
        _joined(nodes, one, other, capacity, neighbor, axis, 2 * free.ndim - 1 - axis)
    return capacity, neighbor


def left_after(choice: Array, take: Array, pairs: Sequence[tuple[Array, Array, Array]]) -> list[Array]:
    """As `seams_after` in kwatra.cut.minimum."""
    choice, left = choice.astype(np.int8), []
    for axis, (a, b, c) in enumerate(pairs):
        cost = np.empty(a.shape, np.int32)
        _left(*(lines(v, axis) for v in (choice, take, a, b, c, cost)))
        left.append(cost)
    return left


def lines(values: Array, axis: int) -> Array:
    """A view of values (a copy, where they are not contiguous) as (before, along, behind) an axis."""
    before, behind = math.prod(values.shape[:axis]), math.prod(values.shape[axis + 1 :])
    return np.ascontiguousarray(values).reshape(before, values.shape[axis], behind)


@jitted
def _priced(choice: Any, a: Any, b: Any, c: Any, weight: Any, ahead: Any, back: Any) -> None:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            for k in range(a.shape[2]):
                p, q = choice[i, j, k], choice[i, j + 1, k]
                keep, one, other = np.int64(a[i, j, k]), np.int64(b[i, j, k]), np.int64(c[i, j, k])
                ahead[i, j, k] = back[i, j, k] = 0
                if p == FREE and q == FREE:
                    old = min(keep, one + other)
                    # any split of -old between the two terminals is exact; the even one leaves the smallest flow
                    up = min(max(-(old // 2), -one), other - old)
                    weight[i, j, k] += up
                    weight[i, j + 1, k] -= old + up
                    ahead[i, j, k], back[i, j, k] = one + up, other - old - up
                elif p == FREE and q == KEEP:
                    weight[i, j, k] += other - keep
                elif p == FREE and q == TAKE:
                    weight[i, j, k] -= one
                elif q == FREE and p == KEEP:
                    weight[i, j + 1, k] += one - keep
                elif q == FREE and p == TAKE:
                    weight[i, j + 1, k] -= other


@jitted
def _joined(node: Any, ahead: Any, back: Any, capacity: Any, neighbor: Any, behind: Any, before: Any) -> None:
    for i in range(ahead.shape[0]):
        for j in range(ahead.shape[1]):
            for k in range(ahead.shape[2]):
                p, q = node[i, j, k], node[i, j + 1, k]
                if p >= 0 and q >= 0 and (ahead[i, j, k] > 0 or back[i, j, k] > 0):
                    capacity[p, before], capacity[q, behind] = ahead[i, j, k], back[i, j, k]
                    neighbor[p, before], neighbor[q, behind] = q, p


@jitted
def _left(choice: Any, take: Any, a: Any, b: Any, c: Any, cost: Any) -> None:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            for k in range(a.shape[2]):
                p, q = take[i, j, k], take[i, j + 1, k]
                if choice[i, j, k] == VOID or choice[i, j + 1, k] == VOID or (p and q):
                    cost[i, j, k] = 0
                elif p:
                    cost[i, j, k] = c[i, j, k]
                elif q:
                    cost[i, j, k] = b[i, j, k]
                else:
                    cost[i, j, k] = a[i, j, k]
