"""How worn a carried frame is: its texture energy (thesis equation 18), pixel by pixel."""

from dataclasses import replace

import torch
from scipy import ndimage
from torch import Tensor

from flow.animation.copies import distortion
from kwatra import Exemplar, Grid
from kwatra.source import SourceWindows, at_windows

_BLUR = 1.0
"""Windows are compared after a blur of this many px, so that a fraction of a pixel between copies is no wear."""

_SETTLED = 1e-3
"""Wear up to which a window is not searched for something better than what it copies."""

_EXACT = 1 << 24
"""Up to so many pairs of windows the search is exact."""


class Wear:
    """Measures frames of `shape` (H, W) against an exemplar, by windows `width` px wide every `step` px.

    Values are in variances of the exemplar: 0 is a verbatim copy, 2 what two unrelated pixels have between them.
    """

    def __init__(self, exemplar: Exemplar, shape: tuple[int, int], width: int, step: int, area: float) -> None:
        self.area = area
        self.variance = max(float((exemplar.variances * exemplar.share.flatten()).sum()), 1e-8)
        fits = (w for w in range(min(width, *shape), 0, -1) if bool(exemplar.corners((w, w)).any()))
        width = next(fits, 1)
        step = min(step, width)
        width -= width % step
        smooth = replace(exemplar, canvas=blurred(exemplar.canvas, exemplar.owner >= 0, _BLUR))
        self.source = SourceWindows(smooth, (width, width), torch.Generator().manual_seed(0))
        self.grid = Grid(shape, (width, width), (step, step), device=exemplar.canvas.device)
        pairs = len(self.grid) * len(self.source.numbers)
        self._route = "exact" if pairs <= _EXACT else "approximate"
        self._mass = self.grid.scatter(self.source.metric.falloff.expand(len(self.grid), -1, -1, 1))[0]

    def __call__(self, image: Tensor, source: Tensor, inside: Tensor) -> Tensor:
        """Wear (H, W) of an image (C, H, W) with its source coordinates (2, H, W); 0 where not inside (H, W)."""
        energy = self._energy(blurred(image, torch.ones_like(inside), _BLUR), source) / self.variance
        windows = energy.view(-1, 1, 1, 1) * self.source.metric.falloff
        wear = self.grid.scatter(windows)[0] / self._mass + self.area * distortion(source)
        return torch.where(inside, wear, 0.0)

    def _energy(self, image: Tensor, source: Tensor) -> Tensor:
        """Squared distance (N,) of each window to the nearest of what it copies and what the search finds."""
        windows = self.grid.gather(image)
        copied = at_windows(self.grid, self.source, source.flip(0).round().long())
        energy = self.source.metric.squared(windows - self.source.windows(copied))
        worn = (energy > _SETTLED * self.variance).nonzero()[:, 0]
        if len(worn):
            windows = windows[worn]
            found = self.source.nearest(self.source.describe(windows), 1, self._route)[:, 0]
            energy[worn] = energy[worn].minimum(self.source.metric.squared(windows - self.source.windows(found)))
        return energy


def blurred(image: Tensor, known: Tensor, width: float) -> Tensor:
    """An image (C, H, W) blurred over its known pixels (H, W) by a Gaussian of `width` px."""

    def blur(values: Tensor) -> Tensor:
        smooth = ndimage.gaussian_filter(values.cpu().numpy(), width, mode="nearest", axes=(1, 2))
        return torch.from_numpy(smooth).to(values.device)

    if bool(known.all()):
        return blur(image)
    return blur(image * known) / blur(known[None].float()).clamp(min=1e-6)
