"""The operator that makes rough flows dear, L = -alpha Laplacian + gamma, and its inverse, which makes flows smooth.

Both by a fast Fourier transform, in which L is a product. Without flow through the border, each component of a flow is
continued beyond it: the one across the border odd, so that it is 0 at the border, the one along it even.
"""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import InputError


@dataclass(frozen=True)
class Smoothness:
    """L = -alpha Laplacian + gamma on flows (..., 2, H, W), x first, with the Laplacian of five points.

    alpha (px^2) > 0: how dear it is that neighbors move apart. gamma > 0: how dear all motion is. wrap: the frame is
    periodic; else nothing flows through its border. Symmetric and positive definite.
    """

    alpha: float
    gamma: float
    wrap: bool = False

    def __post_init__(self) -> None:
        if not (0 < self.alpha < math.inf and 0 < self.gamma < math.inf):
            raise InputError(f"alpha is {self.alpha} and gamma {self.gamma}; give finite numbers above 0")

    def applied(self, flow: Tensor) -> Tensor:
        """L flow."""
        return self._filtered(flow, inverse=False)

    def inverted(self, flow: Tensor) -> Tensor:
        """The flow of which L makes this one: smoother, by about sqrt(alpha / gamma) px."""
        return self._filtered(flow, inverse=True)

    def _filtered(self, flow: Tensor, inverse: bool) -> Tensor:
        height, width = flow.shape[-2:]
        whole = flow if self.wrap else _continued(flow)
        rows, columns = whole.shape[-2:]
        down = 2 - 2 * torch.cos(2 * math.pi * torch.fft.fftfreq(rows, dtype=flow.dtype, device=flow.device))
        across = 2 - 2 * torch.cos(2 * math.pi * torch.fft.rfftfreq(columns, dtype=flow.dtype, device=flow.device))
        symbol = self.alpha * (down[:, None] + across) + self.gamma
        spectrum = torch.fft.rfft2(whole)
        spectrum = spectrum / symbol if inverse else spectrum * symbol
        return torch.fft.irfft2(spectrum, s=(rows, columns))[..., :height, :width]


def _continued(flow: Tensor) -> Tensor:
    """A flow (..., 2, H, W) as one of twice the size that is periodic: x odd across the sides, y across top, bottom."""
    signs = torch.tensor([-1.0, 1.0], dtype=flow.dtype, device=flow.device).view(2, 1, 1)
    wide = torch.cat([flow, signs * flow.flip(-1)], -1)
    return torch.cat([wide, -signs * wide.flip(-2)], -2)
