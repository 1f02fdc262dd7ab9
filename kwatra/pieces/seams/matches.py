"""The matching cost between copies of a mosaic, in loops over a window, compiled; and a patch cut in by one call.

That call goes from places to the seams that are left, and holds no lock of the interpreter's: threads can so cut
several patches side by side.

This module is compiled by numba when first used, so it is imported where seams are priced.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from kwatra.base.axes import AXES
from kwatra.base.compiled import jitted
from kwatra.base.spans import in_volume
from kwatra.cut.choices import FREE, TAKE, VOID
from kwatra.cut.network import cut_at_once, lines, seams_left, sides
from kwatra.pieces.seams.prices import Prices
from kwatra.pieces.seams.stock import Array, Matches


def matched(
    planes: Array,
    strides: Sequence[int],
    old: Array,
    new: Array,
    choice: Array | None = None,
    prices: Prices | None = None,
) -> Matches:
    """M along each axis as `Stock.matches` gives it, of places that are numbers; or what it is priced, given prices.

    planes (C, N): colors by place. strides: from a place to the next one along each axis. choice: what may happen to
    pixels (kwatra.cut); where no seam comes to lie the cost is 0. None: anything.
    """
    choice = np.full(new.shape, FREE, np.int8) if choice is None else choice
    here, found = np.empty(new.shape, np.int32), []
    _apart(planes, choice.ravel(), old.ravel(), new.ravel(), here.ravel())
    for axis, stride in enumerate(strides):
        shape = tuple(n - (d == axis) for d, n in enumerate(new.shape))
        second, first = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
        free, s, t, b, c = (lines(v, axis) for v in (choice, old, new, second, first))
        _matched(planes, stride, free, lines(here, axis), s, t, b, c)
        if prices is not None:
            _priced(prices, AXES - len(strides) + axis, stride, planes.shape[1] - 1, free, s, t, b, c)
        found.append((second, first))
    return found


def cut_in(
    planes: Array,
    strides: Sequence[int],
    old: Array,
    new: Array,
    remembered: Sequence[Array],
    choice: Array,
    taking: Array | None,
    prices: Prices,
    most: int,
) -> tuple[Array, list[Array]] | None:
    """Which pixels of a window take a patch, and the seams then: what `matched`, `best_cut` and `seams_after` make.

    Arrays as there. None, sooner, if they cost over `most` more than now.
    """
    take, seams = np.empty(choice.shape, np.bool_), [np.empty(cost.shape, np.int32) for cost in remembered]
    weight = np.zeros(choice.size, np.int64) if taking is None else taking.astype(np.int64).ravel()
    a, left = (sides(costs, choice.size) for costs in (remembered, seams))
    b, c = (tuple(np.empty(cost.shape, np.int32) for cost in a) for _ in range(2))
    solved = cut_places(
        planes, in_volume(strides, 0), old.ravel(), new.ravel(), prices, choice.ravel(), weight, a, b, c, most,
        take.ravel(), left,
    )  # fmt: skip
    return (take, seams) if solved else None


@jitted
def cut_places(
    planes: Any, strides: Any, old: Any, new: Any, prices: Any, choice: Any, weight: Any, a: Any, b: Any, c: Any,
    most: Any, take: Any, left: Any,
) -> Any:  # fmt: skip
    """As `cut_in`, of pixels (N,); whether it is solved, and `take` (N,) and `left` are set. b, c are written over."""
    here, last = np.empty(len(new), np.int32), planes.shape[1] - 1
    _apart(planes, choice, old, new, here)
    for axis in range(len(a)):
        before, pairs, behind = a[axis].shape
        shape = (before, pairs + 1, behind)
        free, s, t = choice.reshape(shape), old.reshape(shape), new.reshape(shape)
        _matched(planes, strides[axis], free, here.reshape(shape), s, t, b[axis], c[axis])
        _priced(prices, axis, strides[axis], last, free, s, t, b[axis], c[axis])
    solved = cut_at_once(choice, a, b, c, weight, most, take)
    if solved:
        seams_left(choice, take, a, b, c, left)
    return solved


@jitted
def _apart(planes: Any, choice: Any, old: Any, new: Any, here: Any) -> None:
    """How unlike the patches are at a pixel; not asked for where the new one is taken for sure, or none is."""
    for i in range(len(new)):
        if choice[i] == TAKE or choice[i] == VOID:
            here[i] = 0
            continue
        total = np.int32(0)
        for plane in planes:
            total += abs(np.int32(plane[old[i]]) - plane[new[i]])
        here[i] = total


@jitted
def _matched(planes: Any, stride: Any, choice: Any, here: Any, old: Any, new: Any, second: Any, first: Any) -> None:
    last = planes.shape[1] - 1
    for i in range(new.shape[0]):
        for j in range(new.shape[1] - 1):
            for k in range(new.shape[2]):
                if choice[i, j, k] == choice[i, j + 1, k] != FREE:  # no seam comes to lie there
                    continue
                s_new, t_new = new[i, j, k], new[i, j + 1, k]
                ahead, back = min(max(old[i, j, k] + stride, 0), last), min(max(old[i, j + 1, k] - stride, 0), last)
                one, other = here[i, j, k], here[i, j + 1, k]
                for plane in planes:
                    one += abs(np.int32(plane[ahead]) - plane[t_new])
                    other += abs(np.int32(plane[back]) - plane[s_new])
                second[i, j, k], first[i, j, k] = one, other


@jitted
def _priced(
    prices: Any, axis: Any, stride: Any, last: Any, choice: Any, old: Any, new: Any, second: Any, first: Any
) -> None:
    """What `SeamCost` asks for, in place of M, in the same arithmetic."""
    if len(prices.deep) > 0:
        deep, parts, hidden, least = prices.deep, prices.parts, prices.hidden, prices.least
        _hidden(stride, last, choice, old, new, deep, parts, hidden, least, second, first)
    if len(prices.scales) > 0:
        scale, divisor = prices.scales[axis], prices.divisors[axis]
        _divided(stride, last, choice, old, new, scale, divisor, prices.slopes[axis], second, first)


@jitted
def _hidden(
    stride: Any, last: Any, choice: Any, old: Any, new: Any, depths: Any, parts: Any, hidden: Any, least: Any,
    second: Any, first: Any,
) -> None:  # fmt: skip
    """What seams cost where they are hidden."""
    whole, rest = np.float32(hidden), np.float32(1 - hidden)
    for i in range(new.shape[0]):
        for j in range(new.shape[1] - 1):
            for k in range(new.shape[2]):
                if choice[i, j, k] == choice[i, j + 1, k] != FREE:
                    continue
                s_old, s_new, t_old, t_new = old[i, j, k], new[i, j, k], old[i, j + 1, k], new[i, j + 1, k]
                ahead, back = min(max(s_old + stride, 0), last), min(max(t_old - stride, 0), last)
                deep = min(_ending(depths, parts, s_old, ahead), _ending(depths, parts, t_new, s_new))
                more = 0.0 if ahead == t_new else least
                second[i, j, k] = np.int32(np.rint((whole + rest * deep) * np.float64(second[i, j, k]) + more * deep))
                deep = min(_ending(depths, parts, s_new, t_new), _ending(depths, parts, t_old, back))
                more = 0.0 if t_old == t_new else least
                first[i, j, k] = np.int32(np.rint((whole + rest * deep) * np.float64(first[i, j, k]) + more * deep))


@jitted
def _ending(depths: Any, parts: Any, place: Any, beyond: Any) -> Any:
    """How deep in its element a place lies at which it ends, `kwatra.pieces.Depth`'s `ending`."""
    if len(parts) > 0 and (parts[place] == 0 or parts[place] == parts[beyond]):
        return np.float32(1)
    return depths[place]


@jitted
def _divided(
    stride: Any, last: Any, choice: Any, old: Any, new: Any, scale: Any, least: Any, slopes: Any, second: Any,
    first: Any,
) -> None:  # fmt: skip
    """M times a scale, divided by the least and the slopes, if they count, of both patches at both pixels."""
    for i in range(new.shape[0]):
        for j in range(new.shape[1] - 1):
            for k in range(new.shape[2]):
                if choice[i, j, k] == choice[i, j + 1, k] != FREE:
                    continue
                over = under = least
                if len(slopes) > 0:
                    s_old, s_new, t_old, t_new = old[i, j, k], new[i, j, k], old[i, j + 1, k], new[i, j + 1, k]
                    both = slopes[s_new] + slopes[t_new]
                    over += slopes[s_old] + slopes[min(max(s_old + stride, 0), last)] + both
                    under += slopes[t_old] + slopes[min(max(t_old - stride, 0), last)] + both
                second[i, j, k], first[i, j, k] = second[i, j, k] * scale // over, first[i, j, k] * scale // under
