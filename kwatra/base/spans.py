"""Sums over boxes by summed-area tables (thesis 3.3), and pixels as compiled loops see them: with AXES axes."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kwatra.base.axes import AXES


def box_sums(values: np.ndarray, extent: tuple[int, ...]) -> np.ndarray:
    """Sums over every box of `extent` that fits (summed-area table, thesis 3.3): shape n - extent + 1 per axis."""
    spans = [(np.arange(n - e + 1), np.arange(e, n + 1)) for n, e in zip(values.shape, extent, strict=True)]
    return span_sums(values, spans)


def span_sums(values: np.ndarray, spans: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Sums over boxes of the last axes, of up to three, that are every combination of spans: from start to before stop.

    spans: starts and stops of each axis, whole numbers in 0 .. its length. Values may have further axes before.
    """
    from kwatra.base.spanloops import sum_boxes

    axes, kind = len(spans), np.int64 if values.dtype.kind in "biu" else np.float64  # whole numbers are summed exactly
    shape = (*values.shape[: values.ndim - axes], *(len(starts) for starts, _ in spans))
    four = (math.prod(values.shape[: values.ndim - axes]), *volume(values, axes).shape[-AXES:])
    sums = sum_boxes(np.ascontiguousarray(values, np.float64).reshape(four), *of_volume(spans)).reshape(shape)
    return np.asarray(sums, kind)


def of_volume(spans: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """The starts and the stops of spans, of AXES axes (`volume`): the one pixel of those that there are not."""
    every = [(np.zeros(1, np.int64), np.ones(1, np.int64))] * (AXES - len(spans)) + [*spans]
    return tuple(starts for starts, _ in every), tuple(stops for _, stops in every)


def volume(values: np.ndarray, axes: int) -> np.ndarray:
    """Values (..., *S) of pixels that have so many axes, as if they had AXES of them."""
    return values[_AS_VOLUME[axes]]


_AS_VOLUME = {axes: (..., *(None,) * (AXES - axes), *(slice(None),) * axes) for axes in range(1, AXES + 1)}


def in_volume(numbers: Sequence[Any] | np.ndarray, missing: int) -> np.ndarray:
    """Whole numbers (..., axes) of axes, as `volume` has them; `missing` those of the axes that there are not."""
    whole = np.asarray(numbers, np.int64)
    every = np.full((*whole.shape[:-1], AXES), missing, np.int64)
    every[..., AXES - whole.shape[-1] :] = whole
    return every
