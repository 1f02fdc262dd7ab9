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

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice

import torch
from torch import Tensor

from flow.warps import again, followed, interpolated, jacobian, pixel_coordinates
from kwatra.base import mean, over_channels

_FLAT = 1e-6
"""Areas count as no less: where maps fold, the energy has no meaning, and is refused by the search."""

_AT_ONCE = 1 << 17
"""So many values of maps are looked at together: more leave the cache, fewer cost more to call than to do."""


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

    def __call__(self, velocity: Tensor) -> Iterator[tuple[dict[str, Tensor], Tensor]]:
        """Energies of q and of the features for a velocity (N, 2, H, W), means over pixels; the least Jacobian.

        First at A's pixels, then at B's, each counting half.
        """
        for back in (False, True):
            yield self._way(velocity, back)

    def _way(self, velocity: Tensor, back: bool) -> tuple[dict[str, Tensor], Tensor]:
        steps, spent, most = len(velocity), torch.zeros_like(velocity[0, 0]), []
        for numbers, maps in _together(followed(velocity, self.wrap, back)):
            dense = again(partial(density, wrap=self.wrap), maps)
            shares = [(0.5 if number in (0, steps) else 1) / steps for number in numbers]  # the integral, by trapezoids
            spent = spent + (dense * dense.new_tensor(shares).view(-1, 1, 1)).sum(0)
            most.append(dense.detach().max())
        here, there = self.images.flip(0) if back else self.images
        moved = maps[-1]
        place = moved + pixel_coordinates(moved.shape[-2:], moved.device).to(moved.dtype)
        apart = (here - interpolated(there, place, "bicubic", self.wrap)).square()
        energies = {"change": mean(over_channels(apart[: self.colors]) / spent) / 2}
        if self.colors < len(apart):
            energies["features"] = mean(over_channels(apart[self.colors :])) / (2 * self.sigma**2)
        return energies, 1 / torch.stack(most).max()


def _together(maps: Iterator[Tensor]) -> Iterator[tuple[range, Tensor]]:
    """Maps (2, H, W) some at a time (N, 2, H, W), with their numbers: large ones one by one, and not copied."""
    number = 0
    for moved in maps:
        part = [moved, *islice(maps, max(_AT_ONCE // moved.numel() - 1, 0))]
        yield range(number, number + len(part)), torch.stack(part) if len(part) > 1 else moved[None]
        number += len(part)


def density(moved: Tensor, wrap: bool) -> Tensor:
    """How densely (..., H, W) pixels lie that maps move by (..., 2, H, W): 1 / |DX|."""
    return 1 / jacobian(moved, wrap).clamp(min=_FLAT)
