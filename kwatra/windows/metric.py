"""How two windows are compared: Gaussian-weighted color, and any linear feature psi of a window.

The squared distance of windows a and b is |a - b|^2_G + sum_k mu_k |psi_k(a) - psi_k(b)|^2 (thesis 5.2 and 5.3,
equation 21; psi = gradient there). All of it is |E(a - b)|^2 for one linear embedding E, so the search's PCA, the
exact comparison and the blend's normal equations (22) need only E and its transpose.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from kwatra.base import InputError, constant, differentiable


@dataclass(frozen=True)
class Feature:
    """A linear property psi of windows, and its weight mu >= 0 relative to color.

    psi maps windows (N, *width, C) to (N, ...) linearly, and works for any width.
    """

    psi: Callable[[Tensor], Tensor]
    mu: float = 1.0


def gradient(windows: Tensor) -> Tensor:
    """Differences between neighboring pixels along every axis, inside windows (N, *width, C) (thesis 5.3)."""
    return torch.cat([windows.diff(dim=axis).flatten(1) for axis in range(1, windows.ndim - 1)], 1)


def falloff(width: Sequence[int]) -> Tensor:
    """Gaussian falloff of a window (thesis 5.2), shape (*width), sum 1, standard deviation a quarter of the width."""
    result = torch.ones((), dtype=torch.float32)
    for size in width:
        t = torch.arange(size, dtype=torch.float32) - (size - 1) / 2
        g = torch.exp(-8 * t**2 / size**2)
        result = result[..., None] * (g / g.sum())
    return result


class Metric:
    """The embedding E for windows of one width; `channel_weights` (C,) say how much each channel counts.

    falloff (*width, 1), sum 1; share (C,), sum 1; weight (*width, C): their product.
    """

    def __init__(self, width: Sequence[int], channel_weights: Tensor, features: Sequence[Feature] = ()) -> None:
        self.falloff = falloff(width).to(channel_weights.device)[..., None]
        self.share = channel_weights / channel_weights.sum().clamp(min=1e-9)
        self.weight = self.falloff * self.share
        self.root = self.weight.sqrt()
        self._probe = self.weight.new_zeros(1, *self.weight.shape)
        self._features = [(f.psi, self._scale(f)) for f in features if f.mu > 0]
        self.plain = not self._features

    def _scale(self, feature: Feature) -> float:
        """mu per feature value, such that a feature's mean square counts mu times the color's."""
        values = feature.psi(self._probe)
        if values.shape[:1] != (1,) or values.numel() == 0 or bool(values.any()):
            raise InputError(
                f"a feature maps one zero window to shape {tuple(values.shape)}; psi must be linear, (N, *width, C) "
                "to (N, ...)"
            )
        return (feature.mu / values.numel()) ** 0.5

    def features(self, windows: Tensor) -> Tensor:
        """The features' part of the embedding, (N, M); M = 0 without features."""
        parts = [scale * psi(windows).flatten(1) for psi, scale in self._features]
        return torch.cat(parts, 1) if parts else windows.new_zeros(len(windows), 0)

    def features_transposed(self, values: Tensor) -> Tensor:
        """The transpose of `features`: (N, M) to (N, *width, C)."""
        # by the derivative of a sum: other ways to ask for it load a compiler that is not used
        with differentiable():
            zero = constant(self._probe).expand(len(values), *self._probe.shape[1:]).requires_grad_()
            return torch.autograd.grad((self.features(zero) * constant(values)).sum(), zero)[0]

    @cached_property
    def features_diagonal(self) -> Tensor:
        """Diagonal of features' transposed times features, (*width, C)."""
        size = self._probe.numel()
        parts = []
        for first in range(0, size, 512):
            unit = torch.eye(size, dtype=torch.float32, device=self._probe.device)[first : first + 512]
            parts.append((self.features(unit.view(-1, *self._probe.shape[1:])) ** 2).sum(1))
        return torch.cat(parts).view(self._probe.shape[1:])

    @cached_property
    def size(self) -> int:
        """The length M of embedded windows."""
        return self._probe.numel() + self.features(self._probe).shape[1]

    def embed(self, windows: Tensor) -> Tensor:
        """E: windows (N, *width, C) to (N, M)."""
        color = (windows * self.root).flatten(1)
        return color if self.plain else torch.cat([color, self.features(windows)], 1)

    def transposed(self, embedded: Tensor) -> Tensor:
        """E transposed: (N, M) to (N, *width, C)."""
        size = self._probe.numel()
        color = embedded[:, :size].view(-1, *self._probe.shape[1:]) * self.root
        return color if self.plain else color + self.features_transposed(embedded[:, size:])

    def squared(self, difference: Tensor) -> Tensor:
        """Squared length (N,) of window differences: a weighted mean over pixels and channels, plus features."""
        color = difference.square().mul_(self.weight).flatten(1).sum(1)
        return color if self.plain else color + self.features(difference).square().sum(1)
