"""Age: what texture of a video costs that soon cannot live on, so that it is renewed when that shows least.

Where its video ends, or it leaves the video's frame, texture stays as it is (`flow.animation.film`). So it is dearer
from frame to frame over its last ones, and taken where a block agrees with it, piece by piece, each at its own time.
"""

import torch
from torch import Tensor

from flow.animation.film import Film

_LAST = 5
"""So many frames ahead texture begins to age, or a third of a shorter video's."""


class Aging:
    """The age of a film's places; `weight`, in variances, is what a pixel costs that cannot live on."""

    def __init__(self, film: Film, weight: float) -> None:
        last = max(min(_LAST, film.pages // 3), 1)
        self._cost = weight * (1 - film.left / last).clamp(min=0)
        self._ages = film.motion is not None

    def of(self, source: Tensor) -> Tensor:
        """What (*S) pixels at source coordinates (2, *S), x first, cost."""
        if not self._ages:
            return torch.zeros_like(source[0])
        height, width = self._cost.shape
        x, y = source.round().long()
        return self._cost[y.clamp(0, height - 1), x.clamp(0, width - 1)]

    def costs(self, rows: Tensor) -> Tensor:
        """What the pixels of some rows (r,) of the strip cost: (r, W)."""
        return self._cost[rows]
