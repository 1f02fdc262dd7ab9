"""Registration each way, and a dissolve (Kabul et al. 2011, figure 12; Hart, Zach and Niethammer 2009).

    E(v) = |L v|^2 + 1 / sigma^2 |A o phi - B|^2        subject to I_t + DI v = 0, I(0) = A

Two velocities, from A to B and from B to A, each found for itself; frame t is A moved by t of the first, dissolved
into B moved by 1 - t of the second. Colors are compared as they are. What the textures do not share is pulled about
until it matches something, and shows doubled where it does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from flow.warps import displacement, pixel_coordinates, warp
from kwatra.base import InputError
from kwatra.result import Row
from synth.metamorphosis.method import Film, Frames, Method, Pair, Report
from synth.metamorphosis.velocity import PRESETS as SEARCHES
from synth.metamorphosis.velocity import Found, Mismatch, Search


@dataclass(frozen=True)
class Registration(Method):
    """Registration each way, and a dissolve.

    search: for the velocity. sigma: how far colors, in [0, 1], may be from matching.
    """

    search: Search = field(default_factory=Search)
    sigma: float = 0.2

    def __post_init__(self) -> None:
        if not (0 < self.sigma < float("inf")):
            raise InputError(f"sigma is {self.sigma}; give a finite number above 0")

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """See `synth.metamorphosis.method.Method`."""
        there = self._registered(pair.a, pair.b, pair.tile, lambda what, part: report(what, part / 2))
        back = self._registered(pair.b, pair.a, pair.tile, lambda what, part: report(what, (1 + part) / 2))
        shown = (
            torch.lerp(
                _moved(pair.a, there.velocity, time, pair.tile),
                _moved(pair.b, back.velocity, 1 - time, pair.tile),
                time,
            ).clamp(0, 1)
            for time in times
        )
        rows: list[Row] = [*there.energies, *back.energies]
        velocity = (there.velocity - back.velocity.flip(0)) / 2
        remarks = (f"A to B: {there.stopped}", f"B to A: {back.stopped}")
        return Film(Frames(shown, len(times)), tuple(times), velocity, rows, remarks)

    def _registered(self, source: Tensor, target: Tensor, wrap: bool, report: Report) -> Found:
        images = torch.stack([source, target])
        return self.search.velocity(images, lambda images: Mismatch(images, self.sigma, wrap), wrap, report)


def _moved(image: Tensor, velocity: Tensor, time: float, wrap: bool) -> Tensor:
    """An image (C, H, W) moved by a velocity until a time."""
    if time == 0:
        return image
    return warp(
        image, pixel_coordinates(image.shape[1:], image.device) + displacement(velocity, time, 0, wrap), wrap=wrap
    )


PRESETS = {name: Registration(search) for name, search in SEARCHES.items()}
