"""The operator that makes rough flows dear, L = -alpha Laplacian + gamma, and its inverse, which makes flows smooth.

Both by a fast transform in which L is a product: where nothing flows through the border a sine transform in the
direction of a component, which so is 0 at the border, and a cosine transform along it; where the frame is periodic a
Fourier transform. They are SciPy's, on the CPU: unlike torch's, the same bits for any number of threads.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
from scipy import fft
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
        values = flow.detach().cpu().numpy()
        filtered = self._periodic(values, inverse) if self.wrap else self._bordered(values, inverse)
        return torch.from_numpy(filtered).to(flow)

    def _periodic(self, flow: np.ndarray, inverse: bool) -> np.ndarray:
        rows, columns = flow.shape[-2:]
        symbol = self._symbol(fft.fftfreq(rows)[:, None], fft.rfftfreq(columns), inverse)
        filtered: np.ndarray = fft.irfft2(fft.rfft2(flow) * symbol.astype(flow.dtype), s=(rows, columns))
        return filtered

    def _bordered(self, flow: np.ndarray, inverse: bool) -> np.ndarray:
        filtered, sizes = np.empty_like(flow), flow.shape[-2:]
        for component, across in ((0, -1), (1, -2)):
            along = -3 - across
            # the frequencies of the sine transform begin at one half wave, those of the cosine transform at none
            waves = {axis: (np.arange(sizes[axis]) + (axis == across)) / (2 * sizes[axis]) for axis in (-2, -1)}
            symbol = self._symbol(waves[-2][:, None], waves[-1], inverse).astype(flow.dtype)
            spectrum = fft.dst(flow[..., component, :, :], axis=across)
            spectrum = fft.dct(spectrum, axis=along, overwrite_x=True)
            spectrum *= symbol
            spectrum = fft.idct(spectrum, axis=along, overwrite_x=True)
            filtered[..., component, :, :] = fft.idst(spectrum, axis=across, overwrite_x=True)
        return filtered

    def _symbol(self, down: np.ndarray, across: np.ndarray, inverse: bool) -> np.ndarray:
        """What L, or its inverse, multiplies each frequency by, in waves per px."""
        symbol = self.alpha * (4 - 2 * np.cos(2 * math.pi * down) - 2 * np.cos(2 * math.pi * across)) + self.gamma
        return 1 / symbol if inverse else symbol
