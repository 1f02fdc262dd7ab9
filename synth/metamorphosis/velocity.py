"""The velocity of least energy between two textures: what registration and optimal control have in common.

    E(v) = |L v|^2 + what the textures lack of each other after v has moved them,    L = -alpha Laplacian + gamma

(Kabul et al. 2011, equations 1 and 2). The descent is in u = L v: in u the norm of v is the plain one, so that its
gradient is that in the V-norm, and every v = L^-1 u is smooth. Coarse to fine; u, which has the same values at every
resolution, is what a level leaves to the next. Maps that fold have an infinite energy: they are never accepted.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import Smoothness, followed, interpolated, jacobian, pixel_coordinates
from kwatra.base import InputError, coarse_shape, constant, differentiable, mean, over_channels, resized
from kwatra.result import Row
from synth.metamorphosis.descent import Oracle, descent, inner
from synth.metamorphosis.method import Report

Lack = Callable[[Tensor], Iterator[tuple[dict[str, Tensor], Tensor]]]
"""What two textures lack of each other after a velocity (N, 2, H, W): energies by name, means over pixels, and the
least Jacobian of the maps. Differentiable; in parts, to be summed, so that the maps of only one are in memory."""

COARSEST, _FEWEST = 8, 12
"""Levels begin so many times coarser, if so many pixels are left along each axis. Not tuned."""

_ROOM, _LEAST = 0.25, 0.05
"""The least Jacobian that is allowed; coarser levels keep up to _ROOM more, so that the next may begin from them.
Guards, not tuned."""


@dataclass(frozen=True)
class Found:
    """A velocity (N, 2, H, W) in px per step, the energies on the way, why the last level ended, the least Jacobian."""

    velocity: Tensor
    energies: list[Row]
    stopped: str
    least: float


@dataclass(frozen=True)
class Search:
    """How to look for a velocity.

    alpha (px^2): how dear it is that neighbors move apart, so that textures rather fade than bend. gamma: how dear all
    motion is; see `flow.warps.Smoothness`. Both, and steps, were tuned for optimal control on six pairs of photographs
    of 128x128 px: red and dark brick, stones and paving, bands of onyx, terrazzo, hexagonal tiles, pebbles and rocks;
    what they are worth on others was not measured. steps: into so many the time from 0 to 1 is divided. iterations: at
    most so many on each level. tolerance: a level ends when an iteration lowers the energy by less than this share.
    """

    alpha: float = 15.0
    gamma: float = 0.5
    steps: int = 8
    iterations: int = 40
    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        Smoothness(self.alpha, self.gamma)
        if min(self.steps, self.iterations) < 1 or not (0 <= self.tolerance < 1):
            raise InputError(
                f"steps is {self.steps}, iterations {self.iterations} and tolerance {self.tolerance}; give at least 1 "
                "of the first two, and a share in [0, 1)"
            )

    def velocity(self, images: Tensor, lack: Callable[[Tensor], Lack], wrap: bool, report: Report) -> Found:
        """The velocity for two images (2, C, H, W); lack: what says how unlike they are, at any resolution.

        wrap: the textures tile.
        """
        with differentiable():
            return self._found(constant(images), lack, wrap, report)

    def _found(self, images: Tensor, lack: Callable[[Tensor], Lack], wrap: bool, report: Report) -> Found:
        shape = (images.shape[-2], images.shape[-1])
        factors = _factors(shape, wrap)
        found, control = None, images.new_zeros(self.steps, 2, 1, 1)
        rows: list[Row] = []
        for number, factor in enumerate(factors):
            here = coarse_shape(shape, (factor, factor))
            level = SearchLevel(self, factor, lack(_resized(images, factor, here)), wrap)
            part = 1 / 4 ** (len(factors) - number)
            found, control = level.run(number, control, here, _part(report, part, 4 * part))
            rows += found.energies
        assert found is not None
        return replace(found, energies=rows)


PRESETS = {"fast": Search(steps=5, iterations=15), "default": Search(), "best": Search(steps=12, iterations=120)}


class SearchLevel:
    """The search where pixels are `factor` times coarser: there alpha counts 1 / factor, gamma factor times as much."""

    def __init__(self, search: Search, factor: int, lack: Lack, wrap: bool) -> None:
        self.search, self.factor, self.lack = search, factor, lack
        self.smoothness = Smoothness(search.alpha / factor, search.gamma * factor, wrap)
        self.least = _LEAST + _ROOM * (1 - 1 / factor)
        self.seen: dict[str, float] = {}

    def run(self, number: int, start: Tensor, shape: tuple[int, ...], report: Report) -> tuple[Found, Tensor]:
        """What the descent from a control of any size (N, 2, h, w) finds at this one, and its last control."""
        most, rows, stopped = self.search.iterations, [], "no step lowers the energy any more"
        oracle, control = self.oracle(), F.interpolate(start, shape, mode="bilinear", align_corners=False)
        control = self._allowed(control)
        before = math.inf
        for iteration, point in enumerate(descent(oracle, control, self._reach)):
            control = point.at
            place: Row = {"level": number, "factor": self.factor, "iteration": iteration}
            rows.append(place | self.seen | {"total": point.energy})
            report(f"scale 1/{self.factor}, energy {point.energy:.4g}", iteration / most)
            if before - point.energy < self.search.tolerance * point.energy:
                stopped = f"the energy settled in iteration {iteration} of the last level"
                break
            if iteration == most:
                stopped = f"all {most} iterations of the last level were done"
                break
            before = point.energy
        velocity = self.smoothness.inverted(control)
        return Found(velocity, rows, stopped, self._least(velocity)), control

    def oracle(self) -> Oracle:
        """The energy of a control u (N, 2, H, W) and its gradient; `seen` keeps the parts of the last energy."""

        def look(control: Tensor) -> tuple[float, Tensor]:
            gradient, seen = self._lacking(self.smoothness.inverted(control).requires_grad_())
            if gradient is None:
                return math.inf, control
            count = control[:, 0].numel()  # energies are means over time and pixels
            self.seen = {"velocity": float(inner(control, control)) / count} | seen
            return sum(self.seen.values()), self.smoothness.inverted(gradient).add_(control, alpha=2 / count)

        return look

    def _lacking(self, velocity: Tensor) -> tuple[Tensor | None, dict[str, float]]:
        """The gradient of what the textures lack after a velocity, None where a map folds; and the energies by name."""
        gradient, seen = None, dict[str, float]()
        for energies, least in self.lack(velocity):
            if not float(least) > self.least:
                return None, seen
            (slope,) = torch.autograd.grad(torch.stack(list(energies.values())).sum(), velocity)
            gradient = slope if gradient is None else gradient.add_(slope)
            seen = {name: seen.get(name, 0.0) + float(value.detach()) for name, value in energies.items()}
        return gradient, seen

    def _allowed(self, control: Tensor) -> Tensor:
        """The control, or as much of it as does not fold."""
        while not self._least(self.smoothness.inverted(control)) > self.least:
            control = 0.9 * control
        return control

    @torch.no_grad()
    def _least(self, velocity: Tensor) -> float:
        return min(float(least) for _, least in self.lack(velocity))

    def _reach(self, control: Tensor) -> float:
        """How far, in px, the velocity of a control moves pixels, at most; the same whichever end of time is first."""
        speed = self.smoothness.inverted(control).square().sum(1).sqrt()
        return float((speed + speed.flip(0)).sum(0).max()) / 2


@dataclass(frozen=True)
class Mismatch:
    """What images (2, C, H, W) differ by after a velocity has moved the first: a `Lack`."""

    images: Tensor
    sigma: float
    wrap: bool

    def __call__(self, velocity: Tensor) -> Iterator[tuple[dict[str, Tensor], Tensor]]:
        """The energy of the mismatch for a velocity (N, 2, H, W), a mean over pixels, and the least Jacobian."""
        least = []
        for moved in followed(velocity, self.wrap, back=True):
            least.append(jacobian(moved.detach(), self.wrap).min())
        place = moved + pixel_coordinates(velocity.shape[-2:], velocity.device).to(velocity.dtype)
        apart = self.images[1] - interpolated(self.images[0], place, "bicubic", self.wrap)
        yield {"mismatch": mean(over_channels(apart.square())) / self.sigma**2}, torch.stack(least).min()


def _factors(shape: tuple[int, int], wrap: bool) -> list[int]:
    """Coarse to fine; what tiles must be divided evenly."""
    factors = [f for f in (COARSEST, 4, 2) if min(shape) // f >= _FEWEST]
    return [*(f for f in factors if not wrap or all(s % f == 0 for s in shape)), 1]


def _part(report: Report, begin: float, end: float) -> Report:
    """Told of a part of all work, from `begin` to `end`."""
    return lambda what, share: report(what, begin + (end - begin) * share)


def _resized(images: Tensor, factor: int, shape: tuple[int, ...]) -> Tensor:
    return resized(images.flatten(0, 1), (factor, factor), shape).view(2, -1, *shape)
