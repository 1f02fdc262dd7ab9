"""How far on its way from A to B a texture in between is, by measure, and so at which weight it is how far.

With the share of B in each neighborhood as the time, textures keep the character of one for long (Ruiters et al. 2010,
section 6, which hopes for "a perceptual reparameterization"). How far is measured on the neighborhoods themselves:
p = d_A / (d_A + d_B) with d the sliced Wasserstein distance to the windows of A, and of B, once blends have their
detail back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from kwatra.scoring.sliced import sliced_distance
from synth.metamorphosis.bands import Bands
from synth.metamorphosis.patches.model import Matched

_KNOTS = 5
"""Shares of B that are looked at; between them progress is interpolated."""

_WINDOWS, _WIDTH = 150, 7
"""So many neighborhoods are looked at, so many px in the middle of each: a bound on time."""


@dataclass(frozen=True)
class Pace:
    """Shares of B in neighborhoods, from 0 to 1, and how far on their way each is: progress, from 0 to 1 and rising."""

    shares: tuple[float, ...]
    progress: tuple[float, ...]

    @classmethod
    def of(cls, matched: Matched, bands: Sequence[Bands]) -> "Pace":
        """That of the neighborhoods of two textures with these bands."""
        shares = np.linspace(0, 1, _KNOTS)
        count = len(matched.neighborhoods)
        some = torch.randperm(count, generator=torch.Generator().manual_seed(0))[:_WINDOWS]
        sets = [_shown(matched.windows(some, (1 - s, s)), Bands.among(bands, (1 - s, s))) for s in shares.tolist()]
        away = [(sliced_distance(each, sets[0]), sliced_distance(each, sets[-1])) for each in sets]
        part = np.maximum.accumulate([a / max(a + b, 1e-12) for a, b in away])
        if part[-1] <= 0:
            return cls((0.0, 1.0), (0.0, 1.0))
        progress = np.round(part / part[-1], 3)  # so that rounding elsewhere does not show
        return cls(tuple(shares.tolist()), tuple(progress.tolist()))

    def weights(self, times: Tensor) -> Tensor:
        """The shares of B at which textures are so far, 0 to 1, on their way; any shape."""
        return torch.from_numpy(np.interp(times.numpy(), self.progress, self.shares)).float()


def _shown(windows: Tensor, bands: Bands) -> Tensor:
    """The colors in the middle of windows (N, w, w, C + 1), as points, with the detail that frames will have.

    Given once: as often as a finished image is given it, progress moved by .006 at most on six pairs of photographs.
    """
    count, width = windows.shape[:2]
    row = windows[..., :-1].permute(3, 1, 0, 2).flatten(2)  # all windows side by side
    given = bands.given_to(row).clamp(0, 1).view(-1, width, count, width)
    first = max((width - _WIDTH) // 2, 0)
    middle = slice(first, first + _WIDTH)
    return given[:, middle, :, middle].permute(2, 0, 1, 3).flatten(1)
