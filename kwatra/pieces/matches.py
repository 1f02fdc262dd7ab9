"""The matching cost between copies of a mosaic, in one loop over the pairs of a window, compiled.

Arrays are seen as (before, along, behind): what lies before an axis, the axis, what lies behind it.

This module is compiled by numba when first used, so it is imported where seams are priced.
"""

import math
from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.pieces.stock import Array


def matched(planes: Array, old: Array, new: Array, axis: int, stride: int) -> tuple[Array, Array]:
    """M along one axis as `Stock.matches` gives it, of places that are numbers.

    planes (C, N): colors by place. stride: from a place to the next one along the axis.
    """
    lines = math.prod(new.shape[:axis]), new.shape[axis], math.prod(new.shape[axis + 1 :])
    shape = (*new.shape[:axis], lines[1] - 1, *new.shape[axis + 1 :])
    costs = np.empty((2, lines[0], lines[1] - 1, lines[2]), np.int32)
    _matched(planes, old.reshape(lines), new.reshape(lines), stride, costs)
    return costs[0].reshape(shape), costs[1].reshape(shape)


@jitted
def _matched(planes: Any, old: Any, new: Any, stride: Any, costs: Any) -> None:
    last = planes.shape[1] - 1
    for i in range(new.shape[0]):
        for j in range(new.shape[1] - 1):
            for k in range(new.shape[2]):
                s, t, s_new, t_new = old[i, j, k], old[i, j + 1, k], new[i, j, k], new[i, j + 1, k]
                ahead, back = min(max(s + stride, 0), last), min(max(t - stride, 0), last)
                one, other = np.int32(0), np.int32(0)
                for plane in planes:
                    one += abs(np.int32(plane[s]) - plane[s_new]) + abs(np.int32(plane[ahead]) - plane[t_new])
                    other += abs(np.int32(plane[t]) - plane[t_new]) + abs(np.int32(plane[back]) - plane[s_new])
                costs[0, i, j, k], costs[1, i, j, k] = one, other
