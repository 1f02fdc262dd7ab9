"""Boxes on n-D grids that may wrap around."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Box(NamedTuple):
    """A half-open box `start <= u < stop` of output pixels; on an axis that wraps it may reach past the border."""

    start: tuple[int, ...]
    extent: tuple[int, ...]

    @property
    def stop(self) -> tuple[int, ...]:
        """The first position past the box on each axis."""
        return tuple(s + e for s, e in zip(self.start, self.extent, strict=True))

    @property
    def middle(self) -> tuple[int, ...]:
        """The pixel in the middle, or right after it."""
        return tuple(s + e // 2 for s, e in zip(self.start, self.extent, strict=True))

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
