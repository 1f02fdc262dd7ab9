"""Sums over boxes, in compiled loops.

This module is compiled by numba when first used, so it is imported where these are asked for.
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
