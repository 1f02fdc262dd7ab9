"""How much is filled of regions all over a sheet, counted anew only where something was laid since the last time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kwatra.base.spans import span_sums
from kwatra.pieces.boxes import Box
from kwatra.pieces.sheet.sheet import Sheet


class Stations:
    """Regions of `extent` that begin every half of it, and those at the far border; `lines`: where, axis by axis."""

    def __init__(self, sheet: Sheet[Any], extent: Sequence[int]) -> None:
        self._sheet, self._known = sheet, len(sheet.patches)
        self._axes = list(zip(sheet.shape, extent, sheet.periodic, strict=True))
        rooms = [n if wraps else n - e + 1 for n, e, wraps in self._axes]
        self.lines = [_every(room, max(e // 2, 1)) for room, e in zip(rooms, extent, strict=True)]
        self._counts = np.zeros([len(line) for line in self.lines], np.int64)
        self._count(Box((0,) * len(rooms), sheet.shape))

    def counts(self) -> np.ndarray:
        """The number of filled pixels of each region, shaped as `lines` are long."""
        for patch in self._sheet.patches[self._known :]:
            self._count(patch.box)
        self._known = len(self._sheet.patches)
        return self._counts

    def _count(self, box: Box) -> None:
        """Count all regions that touch a box."""
        starts, numbers = [], []
        for line, low, high, (n, e, wraps) in zip(self.lines, box.start, box.stop, self._axes, strict=True):
            near = np.arange(low - e + 1, min(high, low - e + 1 + n))
            near = near[np.isin(near % n if wraps else near, line)]
            if len(near) == 0:
                return
            starts.append(near)
            numbers.append(np.searchsorted(line, near % n))
        extents = [e for _, e, _ in self._axes]
        around = [int(near[-1] - near[0]) + e for near, e in zip(starts, extents, strict=True)]
        at = self._sheet.indices(Box(tuple(int(near[0]) for near in starts), tuple(around)))
        spans = [(near - near[0], near - near[0] + e) for near, e in zip(starts, extents, strict=True)]
        self._counts[np.ix_(*numbers)] = span_sums(self._sheet.filled_at(at), spans)


def _every(count: int, step: int) -> np.ndarray:
    return np.unique(np.append(np.arange(0, count, step), count - 1))
