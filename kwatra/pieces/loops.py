"""Products, quantiles and copies of arrays, what places of a mosaic mean, and how patches lie, in compiled loops.

This module is compiled by numba when first used, so it is imported where these are computed.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def correlate(ones: Any, others: Any, which: Any, into: Any, total: Any) -> None:
    """Sum the products of the conjugates of ones (b, k, N), `which` (n,), with others (n, N), `into` (n,) totals.

    total: (b, m, N).
    """
    total[:] = 0
    for box in range(len(total)):
        for k in range(len(others)):
            one, other, row = ones[box, which[k]], others[k], total[box, into[k]]
            for i in range(len(row)):
                row[i] += one[i].conjugate() * other[i]


@jitted
def quantile(values: Any, share: Any) -> Any:
    """What a share, 0 to 1, of some numbers (N,) is no larger than, as `np.quantile` has it."""
    at = share * (len(values) - 1)
    first = int(at)
    some = values.copy()
    _select(some, first)
    low = some[first]
    high = some[first + 1 :].min() if first + 1 < len(some) else low
    past, step = at - first, high - low
    return high - step * (1 - past) if past >= 0.5 else low + step * past


@jitted
def _select(values: Any, number: int) -> None:
    """Put the value there that sorting would, none larger before it, none smaller behind it (Hoare's Find, 1961)."""
    low, high = 0, len(values) - 1
    while low < high:
        middle, i, j = values[number], low, high
        while i <= j:
            while values[i] < middle:
                i += 1
            while middle < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        if j < number:
            low = i
        if number < i:
            high = j


@jitted
def copy_into(values: Any, to: Any) -> None:
    """Values (N,) in another array; to have a slice assigned takes a second to compile for each kind of arrays."""
    for i in range(len(values)):
        to[i] = values[i]


@jitted
def locate(places: Any, cell: Any, strides: Any, number: Any, at: Any) -> None:
    """The source's number (N,) and the coordinates in it (axes, N) of places (N,) of a mosaic.

    cell: how many places a source takes; strides (axes,): from a place to the next along each axis.
    """
    for i in range(len(places)):
        number[i], rest = divmod(places[i], cell)
        for axis in range(len(strides)):
            step, rest = divmod(rest, strides[axis])
            at[axis, i] = step - 1


@jitted
def patch_sides(shifts: Any, bounds: Any) -> Any:
    """The first pixels (n, AXES) of patches, and those after their last: all that a box shows of a shifted source.

    shifts (n, AXES): of the source; bounds (3, AXES): its size, where the box begins, and where it has ended; all of a
    volume's axes (`kwatra.base.spans.in_volume`).
    """
    starts, stops = np.empty(shifts.shape, np.int64), np.empty(shifts.shape, np.int64)
    for n in range(len(shifts)):
        for axis in range(shifts.shape[1]):
            starts[n, axis] = max(shifts[n, axis], bounds[1, axis])
            stops[n, axis] = min(shifts[n, axis] + bounds[0, axis], bounds[2, axis])
    return starts, stops


@jitted
def find_groups(starts: Any, stops: Any, reach: Any, turns: Any, group: Any) -> None:
    """Set the group (n,) of each box: the first after those of all earlier ones that lie less than `reach` from it.

    starts, stops (n, axes): of the boxes; turns (axes,): after how many pixels an axis wraps, 0 if it does not. Boxes
    lie less than so far from each other if they do along every axis.
    """
    for number in range(len(group)):
        group[number] = 0
        for other in range(number):
            near = True
            for axis in range(len(turns)):
                behind, ahead = starts[other, axis] - stops[number, axis], starts[number, axis] - stops[other, axis]
                away, turn = max(behind, ahead), turns[axis]
                if turn > 0:
                    away = min(away, max(behind - turn, ahead + turn), max(behind + turn, ahead - turn))
                near = near and away < reach
            if near:
                group[number] = max(group[number], group[other] + 1)
