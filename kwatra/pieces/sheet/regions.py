"""The region that needs a patch (thesis section 3.2), the error-region.

While filling, it holds filled and empty pixels, so the texture grows and fits what is there; while refining, it is the
box with the costliest seams, or with random placement any box.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch

from kwatra.base import shared
from kwatra.base.spans import box_sums, in_volume, volume
from kwatra.pieces.boxes import Box, wrapped
from kwatra.pieces.sheet.sheet import Sheet
from kwatra.pieces.sheet.stations import Stations

BAND = 4
"""At first regions are scored in bands as high as so many of them, which threads share: in one band the sums of 2048 a
side would take 100 MB. With 8, or in one, scoring takes as long."""


class Regions:
    """Picks regions of `extent`, or of as much of it as the sheet admits; remembers where it has been."""

    def __init__(self, sheet: Sheet[Any], extent: Sequence[int], generator: torch.Generator):
        self.sheet, self.generator = sheet, generator
        self.extent = tuple(min(e, sheet.longest(d)) for d, e in enumerate(extent))
        self.tried = np.ones(sheet.shape, np.float32)
        self._stations: Stations | None = None
        self._scores: np.ndarray | None = None
        self._highest = np.zeros(())  # of the scores in each stretch of the last axis
        self._known = 0

    def first(self) -> Box:
        """Where an empty sheet begins: its middle."""
        return Box(tuple((n - e) // 2 for n, e in zip(self.sheet.shape, self.extent, strict=True)), self.extent)

    def frontier(self) -> Box:
        """A region on the border of the filled part, about half of it filled."""
        if self._stations is None:
            self._stations = Stations(self.sheet, self.extent)
        lines, score = self._stations.lines, self._half_filled(self._stations.counts())
        if score.max() < 0:  # everywhere if no station is on the border
            filled = wrapped(self.sheet.filled, self.extent, self.sheet.periodic)
            lines = [np.arange(n - e + 1) for n, e in zip(filled.shape, self.extent, strict=True)]
            score = self._half_filled(box_sums(filled, self.extent))
        best = np.flatnonzero((score >= score.max() - 0.1) & (score > 0))
        spot = np.unravel_index(best[self._below(len(best))], score.shape)
        return Box(tuple(int(line[i]) for line, i in zip(lines, spot, strict=True)), self.extent)

    def _half_filled(self, count: np.ndarray) -> np.ndarray:
        """1 where half of a region's pixels are filled, less where more or fewer, -1 where all or none."""
        whole = int(np.prod(self.extent))
        return np.where((count > 0) & (count < whole), 1 - np.abs(count / whole - 0.5), -1)

    def costliest(self) -> Box | None:
        """The region whose seams cost most, regions lately visited counting less; None without seams."""
        return next(iter(self.costliest_apart(1, self.extent)), None)

    def costliest_apart(self, most: int, far: Sequence[int]) -> list[Box]:
        """The regions whose seams cost most, up to so many, each the costliest that lies so far from those before it.

        far: how far from each other they begin, along one axis or another. Along the last one some that lie farther are
        left out as well: all of a STRETCH of which a part is too near.
        """
        from kwatra.pieces.sheet.pixels import STRETCH

        self._score_all()
        assert self._scores is not None
        found, highest = list[Box](), self._highest.copy()
        while len(found) < most:
            *line, part = (int(i) for i in np.unravel_index(int(np.argmax(highest)), highest.shape))
            if highest[(*line, part)] <= 0:
                break
            stretch = self._scores[tuple(line)][part * STRETCH : (part + 1) * STRETCH]
            start = (*line, part * STRETCH + int(np.argmax(stretch)))
            found.append(Box(start, self.extent))
            near = Box(tuple(s - f + 1 for s, f in zip(start, far, strict=True)), tuple(2 * f - 1 for f in far))
            near = near.clipped(self._scores.shape, self.sheet.periodic)
            sides = zip(near.start, near.stop, self._scores.shape, strict=True)
            *lines, last = (np.arange(low, high) % size for low, high, size in sides)
            highest[np.ix_(*lines, np.unique(last // STRETCH))] = 0
        return found

    def _score_all(self) -> None:
        """Have scores of all regions: of those alone again that patches laid since then may have changed."""
        from kwatra.pieces.sheet.pixels import STRETCH

        if self._scores is None:
            self._scores = np.zeros([n if w else n - e + 1 for n, e, w in self._axes])
            *lines, last = self._scores.shape
            self._highest = np.zeros((*lines, -(-last // STRETCH)))
            count, *others = self._scores.shape
            ends = [*range(0, count, BAND * self.extent[0]), count]
            shared(self._score, [(rows, *((0, n) for n in others)) for rows in pairwise(ends)])
        else:
            for patch in self.sheet.patches[self._known :]:
                self._score_around(Box(tuple(s - 1 for s in patch.box.start), tuple(e + 2 for e in patch.box.extent)))
        self._known = len(self.sheet.patches)

    @property
    def _axes(self) -> list[tuple[int, int, bool]]:
        """Per axis the sheet's length, the region's, and whether it wraps."""
        return list(zip(self.sheet.shape, self.extent, self.sheet.periodic, strict=True))

    def _score_around(self, box: Box) -> None:
        """Score anew all regions that touch a box, which may lie beyond the sheet."""
        assert self._scores is not None
        begun = Box(
            tuple(s - e + 1 for s, e in zip(box.start, self.extent, strict=True)),
            tuple(b + e - 1 for b, e in zip(box.extent, self.extent, strict=True)),
        )
        on = begun.clipped(self._scores.shape, self.sheet.periodic)
        spans = [(s, s + min(e, n)) for s, e, n in zip(on.start, on.extent, self._scores.shape, strict=True)]
        if all(low < high for low, high in spans):
            self._score(spans)

    def _score(self, spans: Sequence[tuple[int, int]]) -> None:
        """Score regions that begin within spans, axis by axis: the cost of their seams, less where it was tried."""
        from kwatra.pieces.sheet.pixels import score

        assert self._scores is not None
        axes, (low, high) = len(self.extent), zip(*spans, strict=True)
        sheet = volume(self.sheet.seams, axes), volume(self.tried, axes)
        scored = volume(self._scores, axes), volume(self._highest, axes)
        score(*sheet, in_volume(low, 0), in_volume(high, 1), in_volume(self.extent, 1), *scored)

    def anywhere(self) -> Box:
        """A region drawn at random."""
        spans = zip(self.sheet.shape, self.extent, self.sheet.periodic, strict=True)
        return Box(tuple(self._below(n if wraps else n - e + 1) for n, e, wraps in spans), self.extent)

    def rest(self, region: Box) -> None:
        """Look elsewhere for a while: the seams in and around `region` count half as much from now on."""
        from kwatra.pieces.sheet.pixels import find_highest

        around = Box(
            tuple(s - e // 2 for s, e in zip(region.start, region.extent, strict=True)), region.extent
        ).clipped(self.sheet.shape, self.sheet.periodic)
        self.tried[self.sheet.indices(around)] *= 0.5
        if self._scores is not None:  # the same seams, each score counting half
            begun, axes = around.clipped(self._scores.shape, self.sheet.periodic), len(self.extent)
            self._scores[self.sheet.indices(begun)] *= 0.5
            scored = volume(self._scores, axes), in_volume(begun.start, 0), in_volume(begun.extent, 1)
            find_highest(*scored, volume(self._highest, axes))

    def _below(self, count: int) -> int:
        return int(torch.randint(count, (1,), generator=self.generator))
