"""The image that agrees best with its matched windows and its terms (the E-step of thesis algorithms 1 and 2).

Minimizes sum_p w_p (W_p x - z_p)^T G (W_p x - z_p) + terms over x. Without features and with diagonal terms the
normal equations (thesis 19, with G and w_p of 5.2) are diagonal and solved in closed form. Otherwise (equation 22,
or an F that is not diagonal) by preconditioned conjugate gradients with the diagonal as preconditioner. Fixed pixels
keep their values and masked ones are left out: what is solved for is what is free.
"""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from kwatra.base import mean
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
) -> Tensor:
    """The image (C, *S) that minimizes the energy for given matches (N,) and window weights (N,) >= 0.

    Weights are positive for windows with a free pixel. start: first guess for the iterative solution. given: values
    that are fixed, and the mask. Memory: windows are summed in bands of bounded size.
    """
    metric = source.metric
    channels = source.pixels.shape[-1]
    total = torch.zeros(channels, *grid.shape, device=grid.device)
    mass = torch.zeros(1, *grid.shape, device=grid.device)
    for part, band in bands(grid, metric):
        weight = weights[part].view(-1, *[1] * (len(grid.shape) + 1)) * metric.falloff
        total += band.scatter(weight * source.windows(matches[part]))
        mass += band.scatter(weight)
    unit = mean(mass) if given is None else sum_of(mass * given.free) / given.free.sum().clamp(min=1)
    total, mass = total / unit, mass / unit
    for q in quadratics:
        if q.apply is None:
            total, mass = total + q.diagonal * q.target, mass + q.diagonal
    operators = [q for q in quadratics if q.apply is not None]
    if metric.plain and not operators:
        return total / mass if given is None else given.held(total / mass)
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

    if given is None:
        return conjugate_gradients(system, right, diagonal, total / mass if start is None else start)
    blank, fixed = torch.zeros_like(right), given.held(torch.zeros_like(right))
    right = torch.where(given.fixed, blank, right - system(fixed))
    free = conjugate_gradients(
        lambda x: torch.where(given.fixed, blank, system(x)),
        right,
        torch.where(given.fixed, 1.0, diagonal),
        torch.where(given.fixed, blank, total / mass if start is None else start),
    )
    return given.held(free)


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
        parts = []
        for part, band in bands(self.grid, self.metric):
            windows = windows_of(part, band)
            if self.mask is not None:
                windows = windows * band.gather(self.mask)
            values = self.weights[part] * self.metric.features(windows)
            parts.append(band.scatter(self.metric.features_transposed(values)))
        return torch.stack(parts).sum(0)

    def times(self, x: Tensor) -> Tensor:
        return self._sum(lambda _, band: band.gather(x))

    def pull(self, source: SourceWindows, matches: Tensor) -> Tensor:
        return self._sum(lambda part, _: source.windows(matches[part]))

    def diagonal(self) -> Tensor:
        shape = [1] * self.metric.weight.ndim
        windows = self.weights.view(-1, *shape) * self.metric.features_diagonal
        return self.grid.scatter(windows)


def conjugate_gradients(
    system: Callable[[Tensor], Tensor],
    right: Tensor,
    diagonal: Tensor,
    start: Tensor,
    tolerance: float = 1e-4,
    most: int = 60,
) -> Tensor:
    """Solve system(x) = right for a symmetric positive definite linear map, preconditioned by its diagonal.

    Stops when the residual's norm is `tolerance` of the right side's, or after `most` steps (Hestenes-Stiefel).
    """
    x = start.clone()
    residual = right - system(x)
    goal = tolerance * float(sum_of(right.square()).sqrt())
    direction = step = residual / diagonal
    energy = sum_of(residual * step)
    for _ in range(most):
        if float(sum_of(residual.square()).sqrt()) <= goal:
            break
        image = system(direction)
        length = energy / sum_of(direction * image)
        x = x + length * direction
        residual = residual - length * image
        step = residual / diagonal
        previous, energy = energy, sum_of(residual * step)
        direction = step + energy / previous * direction
    return x
