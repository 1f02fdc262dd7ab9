"""The network of a minimum cut, and the seams that are left after it: loops over the pairs of a grid, compiled.

Arrays are seen as (before, along, behind): what lies before an axis, the axis, what lies behind it. So one loop serves
any axis of any number of dimensions; costs are given of AXES axes, those that an image lacks first and without a pair,
so that a loop is compiled once. A cut that is solved at once is one call from costs to pixels: it holds no lock of
the interpreter's, so threads can solve several side by side.

This module is compiled by numba when first used, so it is imported where a cut is solved.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kwatra.base.axes import AXES
from kwatra.base.compiled import jitted
from kwatra.cut.choices import FREE, KEEP, MOST, TAKE, VOID
from kwatra.cut.flow import FAR, distances_after

Array = np.ndarray[Any, Any]


def at_once(choice: Array, pairs: Sequence[tuple[Array, Array, Array]], taking: Array | None) -> Array:
    """Which pixels take the new patch, as `best_cut` says, of a network of all free pixels."""
    weight = np.zeros(choice.size, np.int64) if taking is None else taking.astype(np.int64).ravel()
    take, (a, b, c) = np.empty(choice.shape, np.bool_), _sides(pairs, choice.size)
    cut_at_once(choice.astype(np.int8).ravel(), a, b, c, weight, MOST, take.ravel())
    return take


def energy(choice: Array, pairs: Sequence[tuple[Array, Array, Array]]) -> tuple[Array, list[tuple[Array, Array]]]:
    """Terminal weights (cost of taking minus cost of keeping) and, per axis, the arcs p -> q and q -> p.

    choice, pairs: as in `best_cut`.
    """
    choice, weight = choice.astype(np.int8), np.zeros(choice.shape, np.int64)
    arcs = []
    for axis, (a, b, c) in enumerate(pairs):
        ahead, back = np.empty(a.shape, np.int64), np.empty(a.shape, np.int64)
        costs = (np.asarray(cost, np.int32) for cost in (a, b, c))
        _priced(*(lines(v, axis) for v in (choice, *costs, weight, ahead, back)))
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
    left, (a, b, c) = [np.empty(pair[0].shape, np.int32) for pair in pairs], _sides(pairs, choice.size)
    taken = np.ascontiguousarray(take).ravel()
    seams_left(choice.astype(np.int8).ravel(), taken, a, b, c, sides(left, choice.size))
    return left


def lines(values: Array, axis: int) -> Array:
    """A view of values (a copy, where they are not contiguous) as (before, along, behind) an axis."""
    before, behind = math.prod(values.shape[:axis]), math.prod(values.shape[axis + 1 :])
    return np.ascontiguousarray(values).reshape(before, values.shape[axis], behind)


def sides(costs: Sequence[Array], pixels: int) -> tuple[Array, ...]:
    """Views as `lines` of what pairs along each axis cost, int32, as of AXES axes."""
    missing = AXES - len(costs)
    there = (lines(cost, axis) for axis, cost in enumerate(costs))
    return (*(np.empty((1, 0, pixels), np.int32) for _ in range(missing)), *there)


def _sides(pairs: Sequence[tuple[Array, Array, Array]], pixels: int) -> list[tuple[Array, ...]]:
    """The costs a, b and c of all axes, each as `sides`."""
    return [sides([np.asarray(pair[n], np.int32) for pair in pairs], pixels) for n in range(3)]


@jitted
def cut_at_once(choice: Any, a: Any, b: Any, c: Any, weight: Any, most: Any, take: Any) -> Any:
    """Solve a cut; choice, weight (what taking costs) and take (N,) are of all pixels, a, b and c of axes.

    Returns whether it was solved: it is given up once it is known to change what seams cost by more than `most`.
    """
    node, count, change = np.empty(len(choice), np.int32), 0, 0
    for i in range(len(choice)):
        node[i] = count if choice[i] == FREE else -1
        count += choice[i] == FREE
    last = -1
    for axis in range(len(a)):
        last += 2 * (a[axis].size > 0)
    residual, near = np.zeros((count, last + 1), np.int64), np.full((count, last + 1), -1, np.int32)
    number = 0
    for axis in range(len(a)):
        if a[axis].size == 0:
            continue
        before, pairs, behind = a[axis].shape
        shape = (before, pairs + 1, behind)
        ahead, back = np.empty(a[axis].shape, np.int64), np.empty(a[axis].shape, np.int64)
        change += _priced(choice.reshape(shape), a[axis], b[axis], c[axis], weight.reshape(shape), ahead, back)
        _joined(node.reshape(shape), ahead, back, residual, near, number, last - number)
        number += 1
    excess, drain = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(len(choice)):
        if node[i] >= 0:
            excess[node[i]], drain[node[i]] = max(weight[i], 0), max(-weight[i], 0)
    left = most - change + drain.sum()
    distance, arrived = distances_after(excess, drain, residual, near, left)
    if arrived > left:
        return False
    for i in range(len(choice)):
        take[i] = distance[node[i]] < FAR if node[i] >= 0 else choice[i] == TAKE
    return True


@jitted
def _priced(choice: Any, a: Any, b: Any, c: Any, weight: Any, ahead: Any, back: Any) -> Any:
    """By how much seams change if all free pixels keep their patch; weights and arcs are what taking it makes of it."""
    change = np.int64(0)
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            for k in range(a.shape[2]):
                p, q = choice[i, j, k], choice[i, j + 1, k]
                keep, one, other = np.int64(a[i, j, k]), np.int64(b[i, j, k]), np.int64(c[i, j, k])
                ahead[i, j, k] = back[i, j, k] = 0
                if p == VOID or q == VOID or p == q == TAKE:
                    change -= keep
                elif p == TAKE:
                    change += other - keep
                elif q == TAKE:
                    change += one - keep
                if p == FREE and q == FREE:
                    old = min(keep, one + other)
                    change += old - keep
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
    return change


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
def seams_left(choice: Any, take: Any, a: Any, b: Any, c: Any, left: Any) -> None:
    """Set what is left of each pair after a cut; choice, take (N,) are of all pixels, the others lines of axes."""
    for axis in range(len(a)):
        before, pairs, behind = a[axis].shape
        states = choice.reshape((before, pairs + 1, behind))
        taken = take.reshape((before, pairs + 1, behind))
        for i in range(before):
            for j in range(pairs):
                for k in range(behind):
                    p, q = taken[i, j, k], taken[i, j + 1, k]
                    if states[i, j, k] == VOID or states[i, j + 1, k] == VOID or (p and q):
                        left[axis][i, j, k] = 0
                    elif p:
                        left[axis][i, j, k] = c[axis][i, j, k]
                    elif q:
                        left[axis][i, j, k] = b[axis][i, j, k]
                    else:
                        left[axis][i, j, k] = a[axis][i, j, k]
