"""How often each pixel of the sources is shown on a sheet, counted anew only where something was laid."""

from __future__ import annotations

import numpy as np

from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Sheet


class Usage:
    """Keeps what the sheet showed when it was asked last, to count what came and went since then."""

    def __init__(self, sheet: Sheet[Mosaic]) -> None:
        self._sheet, self._known = sheet, len(sheet.patches)
        self._shown = np.where(sheet.filled, sheet.places, -1)
        self._counts, self._total = self._counted(self._shown), np.count_nonzero(sheet.filled)

    def relative(self) -> list[np.ndarray]:
        """How often each source pixel is shown, one array per source, over the mean of all of them."""
        sheet, sources = self._sheet, self._sheet.sources
        for patch in sheet.patches[self._known :]:
            at = sheet.indices(patch.box)
            before, now = self._shown[at], np.where(sheet.filled_at(at), sheet.places[at], -1)
            self._counts += self._counted(now) - self._counted(before)
            self._total += np.count_nonzero(now >= 0) - np.count_nonzero(before >= 0)
            self._shown[at] = now
        self._known = len(sheet.patches)
        mean = max(self._total / sum(int(np.prod(shape)) for shape in sources.shapes), 1e-9)
        inner = [tuple(slice(1, n + 1) for n in shape) for shape in sources.shapes]
        cells = self._counts.reshape(-1, *sources.cell)
        return [(cells[k][at] / mean).astype(np.float32) for k, at in enumerate(inner)]

    def _counted(self, places: np.ndarray) -> np.ndarray:
        return np.bincount(places[places >= 0], minlength=self._sheet.sources.planes.shape[1])
