"""Colors on their way from one texture's to another's: the optimal transport of one Gaussian to another.

A texture's colors are taken for a Gaussian of mean m and covariance S. The cheapest way to turn A's into B's moves a
color x to m_B + T (x - m_A) with T = S_A^-1/2 (S_A^1/2 S_B S_A^1/2)^1/2 S_A^-1/2 (Olkin and Pukelsheim, The distance
between two random vectors with given dispersion matrices, 1982); a part t of the way is x + t (that - x).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import mean

_ROUNDS = 12
"""Of the fixed point of `barycenter`, at most; of two Gaussians one is enough, and a second that changes nothing."""

_SETTLED = 1e-12
"""A round that moves colors by no more, as a part of them, is rounding."""

_FLOOR = 1e-5
"""The least variance of a color: below, a texture is all one color, and its deviations lead nowhere."""


@dataclass(frozen=True)
class Colors:
    """A texture's colors as a Gaussian: center (C, 1), covariance (C, C), in double precision."""

    center: Tensor
    covariance: Tensor

    @classmethod
    def of(cls, image: Tensor) -> "Colors":
        """Those of an image (C, H, W)."""
        values = image.flatten(1).double()
        center = torch.stack([mean(v) for v in values])[:, None]
        apart = values - center
        covariance = torch.stack([torch.stack([mean(p * q) for q in apart]) for p in apart])
        return cls(center, covariance + _FLOOR * torch.eye(len(values), dtype=torch.float64, device=image.device))


def transport(own: Tensor, other: Tensor) -> Tensor:
    """The matrix T (C, C) that turns deviations of one covariance (C, C) into those of another."""
    root, inverse = _powers(own, 0.5, -0.5)
    (middle,) = _powers(root @ other @ root, 0.5)
    return inverse @ middle @ inverse


def barycenter(colors: Sequence[Colors], weights: Sequence[float]) -> Colors:
    """The Gaussian between several, by their weights, which sum to 1: least mean squared transport from it to them.

    Of two it is the one on the way. The covariance solves S = sum_k w_k (S^1/2 S_k S^1/2)^1/2, found by iterating
    (Alvarez-Esteban et al., A fixed-point approach to barycenters in Wasserstein space, 2016).
    """
    center = torch.stack([weight * each.center for each, weight in zip(colors, weights, strict=True)]).sum(0)
    found = colors[int(max(range(len(colors)), key=lambda number: weights[number]))].covariance
    for _ in range(_ROUNDS):
        ways = (w * transport(found, each.covariance) for each, w in zip(colors, weights, strict=True))
        move = torch.stack(list(ways)).sum(0)
        found = move @ found @ move.T
        if float((move - torch.eye(len(move)).to(move)).abs().amax()) < _SETTLED:
            break
    return Colors(center, found)


def recolored(image: Tensor, own: Colors, other: Colors, part: float = 1.0) -> Tensor:
    """An image (C, H, W) of colors `own`, a part (0 to 1) of the way to `other`."""
    if part == 0:
        return image
    values = image.flatten(1).double()
    moved = other.center + transport(own.covariance, other.covariance) @ (values - own.center)
    return torch.lerp(values, moved, part).to(image).view_as(image)


def _powers(matrix: Tensor, *exponents: float) -> list[Tensor]:
    """Powers of a symmetric positive definite matrix."""
    values, vectors = torch.linalg.eigh(matrix)
    values = values.clamp(min=_FLOOR**2)
    return [(vectors * values.pow(exponent)) @ vectors.T for exponent in exponents]
