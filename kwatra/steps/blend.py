"""The image that agrees best with its matched windows and its terms (the E-step of thesis algorithms 1 and 2).

Minimizes sum_p w_p (W_p x - z_p)^T G (W_p x - z_p) + terms over x. Without features and with diagonal terms the
normal equations (thesis 19, with G and w_p of 5.2) are diagonal and solved in closed form. Otherwise (equation 22,
or an F that is not diagonal) by preconditioned conjugate gradients with the diagonal as preconditioner. Fixed pixels
keep their values and masked ones are left out: what is solved for is what is free.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import torch
from torch import Tensor

from kwatra.base import Solution, conjugate_gradients, mean
from kwatra.base import total as sum_of
from kwatra.source import CHUNK, SourceWindows
from kwatra.terms import Given, Quadratic
from kwatra.windows import Grid, Metric


def blend(
    grid: Grid,
    source: SourceWindows,
    matches: Tensor,
    weights: Tensor,
    quadratics: Sequence[Quadratic] = (),
    start: Tensor | None = None,
    given: Given | None = None,
    tolerance: float = 1e-4,
    steps: int = 500,
) -> Solution:
    """The image (C, *S) that minimizes the energy for given matches (N,) and window weights (N,) >= 0.

    Weights are positive for windows with a free pixel. start: first guess for the iterative solution, which ends as
    `tolerance` and `steps` of `conjugate_gradients` say. given: values that are fixed, and the mask. Memory: windows
    are summed in bands of bounded size.
    """
    metric = source.metric
    total, mass = _sums(grid, source, matches, weights)
    unit = mean(mass) if given is None else sum_of(mass * given.free) / given.free.sum().clamp(min=1)
    total, mass = total / unit, mass / unit
    for q in quadratics:
        if q.apply is None:
            total, mass = total + q.diagonal * q.target, mass + q.diagonal
    operators = [q for q in quadratics if q.apply is not None]
    if metric.plain and not operators:
        return Solution(total / mass if given is None else given.held(total / mass))
    right, diagonal = total, mass.expand_as(total).clone()
    for q in operators:
        right = right + q.times(q.target.expand_as(total))
        diagonal += q.diagonal
    feature = _FeatureEnergy(grid, metric, weights / unit, None if given is None else given.mask)
    if not metric.plain:
        right = right + feature.pull(source, matches)
        diagonal += feature.diagonal()

    def system(x: Tensor) -> Tensor:
        y = mass * x
        for q in operators:
            y = y + q.times(x)
        return y if metric.plain else y + feature.times(x)

    first = total / mass if start is None else start
    if given is None:
        return conjugate_gradients(system, right, diagonal, first, tolerance, steps)
    return _around(given, system, right, diagonal, first, tolerance, steps)


def _sums(grid: Grid, source: SourceWindows, matches: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted sums of the matched windows, (C, *S), and of their weights, (1, *S)."""
    falloff = source.metric.falloff
    whole = falloff.expand_as(source.metric.weight).contiguous()  # in one stretch, products take a sixth of the time
    total = torch.zeros(whole.shape[-1], *grid.shape, device=grid.device)
    mass = torch.zeros(1, *grid.shape, device=grid.device)
    for part, band in bands(grid, source.metric):
        weight = weights[part].view(-1, *[1] * falloff.ndim)
        total = band.scatter((weight * whole).mul_(source.windows(matches[part])), total)
        mass = band.scatter(weight * falloff, mass)
    return total, mass


def _around(
    given: Given,
    system: Callable[[Tensor], Tensor],
    right: Tensor,
    diagonal: Tensor,
    start: Tensor,
    tolerance: float,
    steps: int,
) -> Solution:
    """The system solved for what is free, around what is given."""
    blank = torch.zeros_like(right)
    found = conjugate_gradients(
        lambda x: torch.where(given.fixed, blank, system(x)),
        torch.where(given.fixed, blank, right - system(given.held(blank))),
        torch.where(given.fixed, 1.0, diagonal),
        torch.where(given.fixed, blank, start),
        tolerance,
        steps,
    )
    return replace(found, x=given.held(found.x))


def bands(grid: Grid, metric: Metric) -> list[tuple[slice, Grid]]:
    """The grid in bands that hold at most about CHUNK values each, with the slice of window indices of each."""
    result, first = [], 0
    for band in grid.bands(max(CHUNK // metric.weight.numel(), 1)):
        result.append((slice(first, first + len(band)), band))
        first += len(band)
    return result


class _FeatureEnergy:
    """sum_p w_p W_p^T psi^T psi W_p, the features' part of the normal equations (thesis equation 22).

    With a mask, windows are compared on their unmasked pixels alone: W_p leaves the others out, for features as for
    colors.
    """

    def __init__(self, grid: Grid, metric: Metric, weights: Tensor, mask: Tensor | None) -> None:
        self.grid, self.metric = grid, metric
        self.weights = weights[:, None]
        self.mask = None if mask is None else mask.float()

    def _sum(self, windows_of: Callable[[slice, Grid], Tensor]) -> Tensor:
        """Windows (N, *width, C) of each band, summed into an image (C, *S)."""
        image = torch.zeros(self.metric.weight.shape[-1], *self.grid.shape, device=self.grid.device)
        for part, band in bands(self.grid, self.metric):
            image = band.scatter(windows_of(part, band), image)
        return image

    def _product(self, windows: Tensor, part: slice, band: Grid) -> Tensor:
        """w_p psi^T psi of windows (N, *width, C)."""
        if self.mask is not None:
            windows = windows * band.gather(self.mask)
        return self.metric.features_transposed(self.weights[part] * self.metric.features(windows))

    def times(self, x: Tensor) -> Tensor:
        return self._sum(lambda part, band: self._product(band.gather(x), part, band))

    def pull(self, source: SourceWindows, matches: Tensor) -> Tensor:
        return self._sum(lambda part, band: self._product(source.windows(matches[part]), part, band))

    def diagonal(self) -> Tensor:
        weights = self.weights.view(-1, *[1] * self.metric.weight.ndim)
        return self._sum(lambda part, _: weights[part] * self.metric.features_diagonal)
