"""What a metamorphosis shows on the way (Kabul et al. 2011, equations 7 and 9).

    I(t, x) = A(phi_t(x)) + what q has changed until then,    phi_t: from coordinates at time t to those at 0

Of all that q changes along a pixel's way, B(phi^r_t(x)) - A(phi_t(x)), the part s done by time t is that of the
integral of 1 / |DX|, so I is a blend of A and B, both read where the pixel comes from and goes to, once each. s is
known in B's coordinates from the forward solution and in A's from the backward one; both weighted by time, 1 - t and
t, make the ends exact.
"""

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from flow.warps import displacement, followed, interpolated, pixel_coordinates, warp
from synth.metamorphosis.optimal_control.energy import density


def frames(velocity: Tensor, a: Tensor, b: Tensor, times: Sequence[float], wrap: bool = False) -> Iterator[Tensor]:
    """The pictures (C, H, W) in [0, 1] at times 0 to 1 along a velocity (N, 2, H, W) from A to B."""
    done = _changed(velocity, wrap)
    return (_frame(velocity, a, b, time, done, wrap) for time in times)


def _frame(velocity: Tensor, a: Tensor, b: Tensor, time: float, done: Tensor, wrap: bool) -> Tensor:
    if time in (0, 1):
        return b if time else a
    pixels = pixel_coordinates(a.shape[1:], a.device)
    from_a = pixels + displacement(velocity, time, 0, wrap)
    from_b = pixels + displacement(velocity, time, 1, wrap)
    in_a = interpolated(_at(done[:, 0], time)[None], from_a, wrap=wrap)
    in_b = interpolated(_at(done[:, 1], 1 - time)[None], from_b, wrap=wrap)
    share = (1 - time) * (1 - in_b) + time * in_a
    shown = (1 - share) * warp(a, from_a, wrap=wrap) + share * warp(b, from_b, wrap=wrap)
    return shown.clamp(0, 1)


def _changed(velocity: Tensor, wrap: bool) -> Tensor:
    """The part of q's change done after each step, (N + 1, 2, H, W): [:, 0] in A's coordinates, [:, 1] in B's."""
    ways = (followed(velocity, wrap, back) for back in (False, True))
    dense = torch.stack([torch.stack([density(moved, wrap) for moved in way]) for way in ways], 1)
    done = torch.cat([torch.zeros_like(dense[:1]), ((dense[1:] + dense[:-1]) / 2).cumsum(0)])
    return done / done[-1]


def _at(values: Tensor, time: float) -> Tensor:
    """Values (N + 1, H, W) at even times, between them linear."""
    place = time * (len(values) - 1)
    before = min(int(place), len(values) - 2)
    return torch.lerp(values[before], values[before + 1], place - before)
