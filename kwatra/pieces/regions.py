"""The region that needs a patch (thesis section 3.2), the error-region.

While filling, it holds filled and empty pixels, so the texture grows and fits what is there; while refining, it is the
box with the costliest seams, or with random placement any box.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from kwatra.pieces.boxes import Box, box_sums, wrapped
from kwatra.pieces.sheet import Sheet


class Regions:
    """Picks regions of `extent`, or of as much of it as the sheet admits; remembers where it has been."""

    def __init__(self, sheet: Sheet[Any], extent: Sequence[int], generator: torch.Generator):
        self.sheet, self.generator = sheet, generator
        self.extent = tuple(min(e, sheet.longest(d)) for d, e in enumerate(extent))
        self.tried = np.ones(sheet.shape, np.float32)

    def first(self) -> Box:
        """Where an empty sheet begins: its middle."""
        return Box(tuple((n - e) // 2 for n, e in zip(self.sheet.shape, self.extent, strict=True)), self.extent)

    def frontier(self) -> Box:
        """A region on the border of the filled part, about half of it filled."""
        filled = box_sums(wrapped(self.sheet.filled, self.extent, self.sheet.periodic), self.extent)
        volume = int(np.prod(self.extent))
        share = filled / volume
        score = np.where((filled > 0) & (filled < volume), 1 - np.abs(share - 0.5), -1)
        lattice = np.full(score.shape, -1.0)
        at = np.ix_(*[_stations(n, max(e // 2, 1)) for n, e in zip(score.shape, self.extent, strict=True)])
        lattice[at] = score[at]
        if lattice.max() < 0:
            lattice = score
        best = np.flatnonzero((lattice >= lattice.max() - 0.1) & (lattice > 0))
        spot = best[self._below(len(best))]
        return Box(tuple(int(i) for i in np.unravel_index(spot, score.shape)), self.extent)

    def costliest(self) -> Box | None:
        """The region whose seams cost most, regions lately visited counting less; None without seams."""
        seams = self.sheet.seams.sum(0, dtype=np.int64)
        sums = box_sums(wrapped(seams, self.extent, self.sheet.periodic), self.extent)
        sums = sums * self.tried[tuple(slice(0, n) for n in sums.shape)]
        if sums.max() <= 0:
            return None
        spot = np.unravel_index(int(np.argmax(sums)), sums.shape)
        return Box(tuple(int(i) for i in spot), self.extent)

    def anywhere(self) -> Box:
        """A region drawn at random."""
        spans = zip(self.sheet.shape, self.extent, self.sheet.periodic, strict=True)
        return Box(tuple(self._below(n if wraps else n - e + 1) for n, e, wraps in spans), self.extent)

    def rest(self, region: Box) -> None:
        """Look elsewhere for a while: the seams in and around `region` count half as much from now on."""
        around = Box(
            tuple(s - e // 2 for s, e in zip(region.start, region.extent, strict=True)), region.extent
        ).clipped(self.sheet.shape, self.sheet.periodic)
        self.tried[self.sheet.indices(around)] *= 0.5

    def _below(self, count: int) -> int:
        return int(torch.randint(count, (1,), generator=self.generator))


def _stations(count: int, step: int) -> np.ndarray:
    return np.unique(np.append(np.arange(0, count, step), count - 1))
