"""How well each translation of a source matches the sheet (thesis 3.2, 3.3).

    whole: C(t) = 1/|A_t| sum over the overlap of |I(p - t) - O(p)|^2      (equation 2)
    sub:   C(t) = the same over the filled pixels of one small region       (equation 4, per pixel)

Both are asked only for translations whose source covers the region, which is what placement needs, and which lets the
transforms be as small as the stretch of sheet such a source can touch. Whole matching keeps what repeats in step;
sub-patch matching is freer, and the one for stochastic textures and for moving ones.
"""

from __future__ import annotations

import numpy as np

from kwatra.base import box_sums
from kwatra.pieces.boxes import Box, everywhere
from kwatra.pieces.choosing import Fit, totals
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Sheet


class Matcher:
    """Match costs over translations of the sources of a sheet; keeps what fits them."""

    def __init__(self, sheet: Sheet[Mosaic]):
        self.sheet = sheet
        self._fits: dict[int, Fit] = {}

    def translations(self, number: int, region: Box) -> Box | None:
        """The translations by which source `number` covers `region`, as a box; None if it is too small to."""
        shape = self.sheet.sources.shapes[number]
        room = tuple(n - e for n, e in zip(shape, region.extent, strict=True))
        if min(room) < 0:
            return None
        return Box(tuple(s - r for s, r in zip(region.start, room, strict=True)), tuple(r + 1 for r in room))

    def reach(self, number: int, region: Box) -> Box:
        """The stretch of sheet that a source can touch while it covers `region`."""
        shape = self.sheet.sources.shapes[number]
        start = tuple(s + e - n for s, e, n in zip(region.start, region.extent, shape, strict=True))
        return Box(start, tuple(2 * n - e for n, e in zip(shape, region.extent, strict=True)))

    def whole(self, number: int, region: Box) -> np.ndarray:
        """Equation 2 for each of `translations(number, region)`; infinite where nothing overlaps."""
        return _per_pixel(*self._fit(number).under(*self.read(self.reach(number, region))))

    def sub(self, number: int, region: Box) -> np.ndarray:
        """Equation 4 for each of `translations(number, region)`, over the filled pixels of `region`, per pixel."""
        colors, mask = self.read(region)
        # The fit runs over where the region lies in the source, which is the translation backwards.
        cost = np.flip(self._fit(number).inside(colors, mask))
        return _per_pixel(cost, np.full(cost.shape, np.count_nonzero(mask)))

    def mean_usage(self, number: int, region: Box, usage: np.ndarray, empty: bool) -> np.ndarray:
        """Mean of `usage` over the source pixels that each translation brings to the empty sheet, or to `region`."""
        if not empty:
            return np.flip(box_sums(usage, region.extent)) / np.prod(region.extent)
        vacant = self._vacant(self.reach(number, region))
        return totals(usage, vacant) / np.maximum(box_sums(vacant > 0, usage.shape), 1)

    def read(self, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """The sheet in a box: colours (0 where empty or outside) and the mask of filled pixels, both float32."""
        sheet = self.sheet
        at = sheet.indices(box)
        inside = self._inside(box) & sheet.filled_at(at)
        mask = inside.astype(np.float32)
        return sheet.sources.matching_at(sheet.places[at]) * mask, mask

    def _vacant(self, box: Box) -> np.ndarray:
        return (self._inside(box) & ~self.sheet.filled_at(self.sheet.indices(box))).astype(np.float32)

    def _inside(self, box: Box) -> np.ndarray:
        lines = zip(box.start, box.stop, self.sheet.shape, self.sheet.periodic, strict=True)
        spans = [(np.arange(a, b) >= 0) & (np.arange(a, b) < n) | wraps for a, b, n, wraps in lines]
        return everywhere(spans)

    def _fit(self, number: int) -> Fit:
        if number not in self._fits:
            self._fits[number] = Fit(self.sheet.sources.matching(number))
        return self._fits[number]


def _per_pixel(cost: np.ndarray, area: np.ndarray) -> np.ndarray:
    return np.where(area > 0, cost / np.maximum(area, 1), np.inf)
