"""The matching cost between copies of a mosaic, in one loop over the pairs of a window, compiled.

This module is compiled by numba when first used, so it is imported where seams are priced.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.cut.network import lines
from kwatra.pieces.stock import Array


def matched(planes: Array, old: Array, new: Array, axis: int, stride: int) -> tuple[Array, Array]:
    """M along one axis as `Stock.matches` gives it, of places that are numbers.

    planes (C, N): colors by place. stride: from a place to the next one along the axis.
    """
    shape = tuple(n - (d == axis) for d, n in enumerate(new.shape))
    second, first = np.empty(shape, np.int32), np.empty(shape, np.int32)
    _matched(planes, stride, *(lines(v, axis) for v in (old, new, second, first)))
    return second, first


@jitted
def _matched(planes: Any, stride: Any, old: Any, new: Any, second: Any, first: Any) -> None:
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
                second[i, j, k], first[i, j, k] = one, other
