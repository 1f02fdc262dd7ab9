"""The energy of a metamorphosis (Kabul et al. 2011), as a function of its velocity alone.

    E(v) = |L v|^2 + |q|^2 + 1 / sigma^2 |F o phi - F'|^2        subject to I_t + DI v = q, I(0) = A, I(1) = B

v moves the picture, q changes its colors on the way. What comes to the pixel y of B from A's place X_0(y) has to
change by r(y) = B(y) - A(X_0(y)). With X_t(y) the place on the way, pixels there count |DX_t(y)| times y's area, so
the least |q|^2 that makes up for r is that of

    q(t, X_t(y)) = a_t(y) r(y) / S(y),    a_t = 1 / |DX_t|,    S = integral of a_t over t,

and its energy is r(y)^2 / S(y), summed over y. This is equation 8 with the conservation law, equation 6; there
Phi_{1,t} is X_t, the map from coordinates at time 1 to those at t, and |D Phi^r| in (6) is 1 / |DX_t|.

The same from B to A, with the same v, gives equation 9 its second half. Were both q's free under its weights 1 - t and
t, all change would wait for t = 1, where it costs nothing; the paper weighs solutions of the unweighted problem
(eq. 10). Those agree but for rounding, so that half of the one's energy and half of the other's is that of eq. 9; it is
what is minimized here. Its gradient, 2 L^T L v + lambda DI^T, is left to automatic differentiation of the sums below.

Where the paper slips: by (9) algorithm 1 means (8), by "lambda 2" half of lambda; and omega(1) in (15) needs the other
sign, that of lambda(1) = 2 q(1), since both carry what is lacking at time 1.
"""

from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor

from flow.warps import again, displaced, interpolated, jacobian, pixel_coordinates
from kwatra.base import mean

_FLAT = 1e-6
"""Areas count as no less: where maps fold, the energy has no meaning, and is refused by the search."""


@dataclass(frozen=True)
class Change:
    """What q and the features cost after a velocity: see `synth.metamorphosis.velocity.Lack`.

    images (2, C + K, H, W): A's and B's C colors, which q may change, and K features, which it may not (eq. 14).
    sigma: how far from matching a feature may be, in its own units. wrap: the textures tile.
    """

    images: Tensor
    colors: int
    sigma: float
    wrap: bool = False

    def __call__(self, velocity: Tensor) -> tuple[dict[str, Tensor], Tensor]:
        """Energies of q and of the features for a velocity (N, 2, H, W), means over pixels; the least Jacobian."""
        moved = both_ways(velocity, self.wrap)
        area = torch.stack([again(partial(jacobian, wrap=self.wrap), each) for each in moved])
        place = moved[-1] + pixel_coordinates(velocity.shape[-2:], velocity.device).to(velocity.dtype)
        apart = (self.images - interpolated(self.images.flip(0), place, "bicubic", self.wrap)).square()
        energies = {"change": _mean(apart[:, : self.colors].sum(1) / _integral(1 / area.clamp(min=_FLAT)))}
        if self.colors < apart.shape[1]:
            energies["features"] = _mean(apart[:, self.colors :].sum(1)) / self.sigma**2
        return energies, area.min()


def both_ways(velocity: Tensor, wrap: bool) -> Tensor:
    """How far pixels have moved after each step, (N + 1, 2, 2, H, W): [:, 0] A's towards B, [:, 1] B's towards A."""
    return displaced(torch.stack([velocity, -velocity.flip(0)], 1), wrap)


def _integral(values: Tensor) -> Tensor:
    """Over time from 0 to 1, of values at even times (N + 1, ...), by trapezoids."""
    return ((values[1:] + values[:-1]) / 2).mean(0)


def _mean(values: Tensor) -> Tensor:
    """Mean over pixels of the average of both ways (2, H, W); the same bits whichever comes first."""
    return (mean(values[0]) + mean(values[1])) / 2
