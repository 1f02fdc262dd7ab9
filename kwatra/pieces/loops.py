"""Sums, products and quantiles of arrays, and what places of a mosaic mean, in compiled loops.

This module is compiled by numba when first used, so it is imported where these are computed.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def sum_spans(values: Any, starts: Any, stops: Any, sums: Any) -> None:
    """Sums (before, spans, behind) of values (before, along, behind) from each start to before its stop."""
    table = np.zeros((values.shape[1] + 1, values.shape[2]), sums.dtype)
    for i in range(values.shape[0]):
        if values.shape[2] == 1:  # the last axis: loops over nothing behind it take twice as long
            _sum_line(values[i, :, 0], starts, stops, table[:, 0], sums[i, :, 0])
            continue
        for j in range(values.shape[1]):
            _add(table[j], values[i, j], table[j + 1])
        for span in range(len(starts)):
            _subtract(table[stops[span]], table[starts[span]], sums[i, span])


@jitted
def sum_boxes(values: Any, starts: Any, stops: Any) -> Any:
    """Sums (before, i, j, k) of values (before, A, B, C) over all boxes from starts to before stops of the axes."""
    n, a, b, c = values.shape
    planes, rows, columns = len(starts[0]), len(starts[1]), len(starts[2])
    one = values
    if a > 1 or planes > 1 or stops[0][0] - starts[0][0] != 1:
        one = np.empty((n, planes, b, c), values.dtype)
        sum_spans(values.reshape((n, a, b * c)), starts[0], stops[0], one.reshape((n, planes, b * c)))
    two = np.empty((n, planes, rows, c), values.dtype)
    sum_spans(one.reshape((n * planes, b, c)), starts[1], stops[1], two.reshape((n * planes, rows, c)))
    three = np.empty((n, planes, rows, columns), values.dtype)
    last = (n * planes * rows, c, 1), (n * planes * rows, columns, 1)
    sum_spans(two.reshape(last[0]), starts[2], stops[2], three.reshape(last[1]))
    return three


@jitted
def _add(one: Any, other: Any, total: Any) -> None:
    for k in range(len(total)):
        total[k] = one[k] + other[k]


@jitted
def _subtract(one: Any, other: Any, rest: Any) -> None:
    for k in range(len(rest)):
        rest[k] = one[k] - other[k]


@jitted
def _sum_line(values: Any, starts: Any, stops: Any, table: Any, sums: Any) -> None:
    for j in range(len(values)):
        table[j + 1] = table[j] + values[j]
    for span in range(len(starts)):
        sums[span] = table[stops[span]] - table[starts[span]]


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
def locate(places: Any, cell: Any, strides: Any, number: Any, at: Any) -> None:
    """The source's number (N,) and the coordinates in it (axes, N) of places (N,) of a mosaic.

    cell: how many places a source takes; strides (axes,): from a place to the next along each axis.
    """
    for i in range(len(places)):
        number[i], rest = divmod(places[i], cell)
        for axis in range(len(strides)):
            step, rest = divmod(rest, strides[axis])
            at[axis, i] = step - 1
