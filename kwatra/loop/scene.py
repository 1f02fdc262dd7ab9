"""One level of an optimization at work: enter it with what the level before left, then iterate.

An iteration is `step`: search (M), robust weights, blend (E) - thesis algorithms 1 and 2 with section 5.2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import Solution, mean, total
from kwatra.levels import Level
from kwatra.settings import Settings
from kwatra.source import Prepared, sourcemap
from kwatra.steps import Matching, blend, rho, weight
from kwatra.terms import Controls, Quadratic, TermLike, wish_of
from kwatra.windows import Grid, step_of


@dataclass(frozen=True)
class State:
    """Where the loop stands on a level: the image (C, *S), its matches (N,) or None before the first search."""

    image: Tensor
    matches: Tensor | None
    weights: Tensor
    iteration: int = 0
    energy: float = math.inf
    changed: float = 1.0


class Scene:
    """The exemplar's windows, the output's grid and what is asked of it at one level.

    exemplar, shape, terms and mask are those of the full resolution.
    """

    def __init__(
        self,
        exemplar: Prepared,
        shape: tuple[int, ...],
        terms: Sequence[TermLike],
        level: Level,
        settings: Settings,
        generator: torch.Generator,
        mask: Tensor | None = None,
    ) -> None:
        axes = len(shape)
        self.level, self.settings, self.generator = level, settings, generator
        self.factors = level.factors(axes)
        width = level.window(axes)
        self.source = exemplar.windows(self.factors, width, generator, settings.features)
        channels = len(exemplar.exemplar.weights)
        self.controls = Controls(terms, mask, self.factors, shape, channels, self.source.device)
        self.shape = self.controls.shape
        self.grid = Grid(self.shape, width, tuple(map(step_of, width)), settings.wrap, device=self.source.device)
        self.matching = Matching(self.source, self.grid, settings.candidates, self.controls.given)

    def route(self, inherited: bool) -> str:
        """How to search: exactly while that is cheap, else by coherence or, with nothing to go by, approximately."""
        wanted = self.level.route
        if wanted is not None and (inherited or wanted != "coherent"):
            return wanted
        if len(self.grid) * len(self.source.numbers) <= self.settings.exact_pairs:
            return "exact"
        return "coherent" if inherited else "approximate"

    def enter(self, image: Tensor | None, where: Tensor | None, factors: Sequence[int]) -> State:
        """The state in which this level begins, from an image, a source map, both or neither.

        factors: the resolution that both have. With a map of another resolution the image is made anew from it.
        """
        ones = torch.ones(len(self.grid), device=self.grid.device)
        same = tuple(factors) == self.factors
        if where is None and image is not None:
            return State(self.controls.shrunk(image), None, ones)
        if where is None:
            pick = torch.randint(len(self.source.numbers), (len(self.grid),), generator=self.generator)
            matches = self.source.numbers[pick.to(self.grid.device)]
        else:
            carried = where if same else sourcemap.carried(where, factors, self.factors, self.shape)
            matches = sourcemap.at_windows(self.grid, self.source, carried)
        if image is None or not same:
            image = self._blended(matches, ones).x
        return State(image, matches, ones)

    def step(self, state: State) -> tuple[State, dict[str, float | str]]:
        """One EM iteration: the next state, and its energies by name."""
        route = self.route(state.matches is not None)
        quadratics = self.controls.quadratics(state.image)
        wish = wish_of(quadratics, state.image)
        found = self.matching.best(state.image, state.matches, wish, route)
        matches, weights = found.matches, weight(found.free, self.settings.r)
        if self.matching.active is not None:
            weights = weights * self.matching.active
        solution = self._blended(matches, weights, quadratics, state.image)
        image = solution.x
        energies = {"texture": self._mean(rho(found.squared, self.settings.r))}
        for name, value in self.controls.energies(image):
            energies[name] = energies.get(name, 0.0) + value
        sum_ = sum(energies.values())
        changed = 1.0 if state.matches is None else self._mean((matches != state.matches).float())
        row = {"route": route, "changed": changed, **energies, "total": sum_}
        if solution.residual > 0:
            row["residual"] = solution.residual
        return State(image, matches, weights, state.iteration + 1, sum_, changed), row

    def _blended(
        self, matches: Tensor, weights: Tensor, quadratics: Sequence[Quadratic] = (), start: Tensor | None = None
    ) -> Solution:
        """The blend on this level, solved as far as the settings ask."""
        tolerance, steps, given = self.settings.solver_tolerance, self.settings.solver_steps, self.controls.given
        return blend(self.grid, self.source, matches, weights, quadratics, start, given, tolerance, steps)

    def _mean(self, values: Tensor) -> float:
        """Mean of values (N,) over the windows with a free pixel, 0 where there are none."""
        active = self.matching.active
        if active is None:
            return float(mean(values))
        return float(total(values * active)) / max(int(active.sum()), 1)
