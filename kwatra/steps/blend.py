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
from kwatra.steps.votes import Ballot, Pull, Vote, bands
from kwatra.steps.votes import mean as mean_vote
from kwatra.terms import Given, Quadratic
from kwatra.windows import Layout

_TRACE = 1e-9
"""The mass of what a pixel has where no window pulls: any term outweighs it."""


def blend(
    ballot: Ballot,
    quadratics: Sequence[Quadratic] = (),
    start: Tensor | None = None,
    given: Given | None = None,
    vote: Vote = mean_vote,
    tolerance: float = 1e-4,
    steps: int = 500,
) -> Solution:
    """The image (C, *S) that minimizes the energy for given matches and window weights.

    Weights are positive for windows with a free pixel; pixels that no window covers and no term wants are those of
    `start`, or 0. start: also the first guess for the iterative solution, which ends as `tolerance` and `steps` of
    `conjugate_gradients` say. given: values that are fixed, and the mask.
    """
    value, mass = vote(ballot)
    bare = mass == 0
    if bool(bare.any()):
        value = torch.where(bare, 0.0 if start is None else start, value)
        mass = torch.where(bare, _TRACE, mass)
    if quadratics:  # what they weigh is told in what the mean pixel's windows weigh together
        unit = mean(mass) if given is None else sum_of(mass * given.free) / given.free.sum().clamp(min=1)
        quadratics = [q.scaled(unit) for q in quadratics]
    equations = _Equations(ballot, Pull(value, mass), quadratics, given)
    if equations.diagonal_only:
        return Solution(equations.value if given is None else given.held(equations.value))
    return equations.solved(equations.value if start is None else start, tolerance, steps)


class _Equations:
    """The normal equations of the energy in x."""

    def __init__(self, ballot: Ballot, pull: Pull, quadratics: Sequence[Quadratic], given: Given | None) -> None:
        self.given = given
        self.value, self.mass = pull
        for q in quadratics:
            if q.apply is None:
                total, self.mass = self.mass * self.value + q.diagonal * q.target, self.mass + q.diagonal
                self.value = total / self.mass
        self.operators = [q for q in quadratics if q.apply is not None]
        mask = None if given is None else given.mask
        self.features = None if ballot.source.metric.plain else _FeatureEnergy(ballot, mask)

    @property
    def diagonal_only(self) -> bool:
        """Whether every pixel is solved by itself."""
        return self.features is None and not self.operators

    def times(self, x: Tensor) -> Tensor:
        """The system's matrix times an image."""
        y = self.mass * x
        for q in self.operators:
            y = y + q.times(x)
        return y if self.features is None else y + self.features.times(x)

    def solved(self, start: Tensor, tolerance: float, steps: int) -> Solution:
        """The image that solves them, begun at `start`; fixed values stay out of the unknowns."""
        right, diagonal = self.mass * self.value, self.mass.expand_as(self.value).clone()
        for q in self.operators:
            right = right + q.times(q.target.expand_as(right))
            diagonal += q.diagonal
        if self.features is not None:
            right = right + self.features.pull()
            diagonal += self.features.diagonal()
        if self.given is None:
            return conjugate_gradients(self.times, right, diagonal, start, tolerance, steps)
        fixed, blank = self.given.fixed, torch.zeros_like(right)
        found = conjugate_gradients(
            lambda x: torch.where(fixed, blank, self.times(x)),
            torch.where(fixed, blank, right - self.times(self.given.held(blank))),
            torch.where(fixed, 1.0, diagonal),
            torch.where(fixed, blank, start),
            tolerance,
            steps,
        )
        return replace(found, x=self.given.held(found.x))


class _FeatureEnergy:
    """sum_p w_p W_p^T psi^T psi W_p, the features' part of the normal equations (thesis equation 22).

    With a mask, windows are compared on their unmasked pixels alone: W_p leaves the others out, for features as for
    colors.
    """

    def __init__(self, ballot: Ballot, mask: Tensor | None) -> None:
        self.ballot, self.layout, self.metric = ballot, ballot.layout, ballot.source.metric
        self.weights = ballot.weights[:, None]
        self.mask = None if mask is None else mask.float()

    def _sum(self, windows_of: Callable[[slice, Layout], Tensor]) -> Tensor:
        """Windows (N, *width, C) of each band, summed into an image (C, *S)."""
        image = torch.zeros(
            self.metric.weight.shape[-1], *self.layout.shape, dtype=torch.float32, device=self.layout.device
        )
        for part, band in bands(self.layout, self.metric):
            image = band.scatter(windows_of(part, band), image)
        return image

    def _product(self, windows: Tensor, part: slice, band: Layout) -> Tensor:
        """w_p psi^T psi of windows (N, *width, C)."""
        if self.mask is not None:
            windows = windows * band.gather(self.mask)
        return self.metric.features_transposed(self.weights[part] * self.metric.features(windows))

    def times(self, x: Tensor) -> Tensor:
        return self._sum(lambda part, band: self._product(band.gather(x), part, band))

    def pull(self) -> Tensor:
        source, matches = self.ballot.source, self.ballot.matches
        return self._sum(lambda part, band: self._product(source.windows(matches[part]), part, band))

    def diagonal(self) -> Tensor:
        weights = self.weights.view(-1, *[1] * self.metric.weight.ndim)
        return self._sum(lambda part, _: weights[part] * self.metric.features_diagonal)
