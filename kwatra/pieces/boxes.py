"""Boxes and box sums on n-D grids that may wrap around: small tools the other rooms share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kwatra.base.axes import AXES


@dataclass(frozen=True)
class Box:
    """A half-open box `start <= u < stop` of output pixels; on an axis that wraps it may reach past the border."""

    start: tuple[int, ...]
    extent: tuple[int, ...]

    @property
    def stop(self) -> tuple[int, ...]:
        """The first position past the box on each axis."""
        return tuple(s + e for s, e in zip(self.start, self.extent, strict=True))

    def within(self, other: Box) -> Box:
        """What two boxes have in common."""
        start = tuple(max(pair) for pair in zip(self.start, other.start, strict=True))
        stop = tuple(min(pair) for pair in zip(self.stop, other.stop, strict=True))
        return Box(start, tuple(max(b - a, 0) for a, b in zip(start, stop, strict=True)))

    def part(self, box: Box) -> tuple[slice, ...]:
        """The index of a box that lies in this one, into arrays over this one."""
        sides = zip(box.start, self.start, box.extent, strict=True)
        return tuple(slice(start - first, start - first + extent) for start, first, extent in sides)

    def clipped(self, shape: tuple[int, ...], periodic: tuple[bool, ...]) -> Box:
        """The part of the box that lies on a grid of `shape`; axes that wrap are left as they are."""
        spans = [
            (s, e) if wraps else (max(s, 0), min(s + e, n) - max(s, 0))
            for s, e, n, wraps in zip(self.start, self.extent, shape, periodic, strict=True)
        ]
        return Box(tuple(s for s, _ in spans), tuple(max(e, 0) for _, e in spans))


def box_sums(values: np.ndarray, extent: tuple[int, ...]) -> np.ndarray:
    """Sums over every box of `extent` that fits (summed-area table, thesis 3.3): shape n - extent + 1 per axis."""
    spans = [(np.arange(n - e + 1), np.arange(e, n + 1)) for n, e in zip(values.shape, extent, strict=True)]
    return span_sums(values, spans)


def span_sums(values: np.ndarray, spans: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Sums over boxes of the last axes, of up to three, that are every combination of spans: from start to before stop.

    spans: starts and stops of each axis, whole numbers in 0 .. its length. Values may have further axes before.
    """
    from kwatra.pieces.loops import sum_boxes

    axes, kind = len(spans), np.int64 if values.dtype.kind in "biu" else np.float64  # whole numbers are summed exactly
    shape = (*values.shape[: values.ndim - axes], *(len(starts) for starts, _ in spans))
    four = (math.prod(values.shape[: values.ndim - axes]), *volume(values, axes).shape[-AXES:])
    sums = sum_boxes(values.astype(np.float64, copy=False).reshape(four), *of_volume(spans)).reshape(shape)
    return np.asarray(sums, kind)


def of_volume(spans: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """The starts and the stops of spans, of AXES axes (`volume`): the one pixel of those that there are not."""
    every = [(np.zeros(1, np.int64), np.ones(1, np.int64))] * (AXES - len(spans)) + [*spans]
    return tuple(starts for starts, _ in every), tuple(stops for _, stops in every)


def volume(values: np.ndarray, axes: int) -> np.ndarray:
    """Values (..., *S) of pixels that have so many axes, as if they had AXES of them."""
    before = values.ndim - axes
    return values.reshape(*values.shape[:before], *(1,) * (AXES - axes), *values.shape[before:])


def in_volume(numbers: Sequence[Any] | np.ndarray, missing: int) -> np.ndarray:
    """Whole numbers (..., axes) of axes, as `volume` has them; `missing` those of the axes that there are not."""
    whole = np.asarray(numbers, np.int64)
    before = np.full((*whole.shape[:-1], AXES - whole.shape[-1]), missing, np.int64)
    return np.concatenate([before, whole], -1)


def wrapped(values: np.ndarray, extent: tuple[int, ...], periodic: tuple[bool, ...]) -> np.ndarray:
    """`values` continued past the far border of each axis that wraps, so that a box may start anywhere."""
    for axis, (length, wraps) in enumerate(zip(extent, periodic, strict=True)):
        if wraps and length > 1:
            count = values.shape[axis]
            values = np.take(values, np.arange(count + length - 1) % count, axis)
    return values


def everywhere(lines: list[np.ndarray]) -> np.ndarray:
    """The n-D boolean grid that is True where every axis' line is."""
    grid = np.ones((1,) * len(lines), bool)
    for axis, line in enumerate(lines):
        grid = grid & line.reshape([-1 if d == axis else 1 for d in range(len(lines))])
    return grid
