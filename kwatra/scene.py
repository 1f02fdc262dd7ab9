"""One level of an optimization at work: enter it with what the level before left, then iterate.

An iteration is `step`: search (M), robust weights, blend (E) - thesis algorithms 1 and 2 with section 5.2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra import sourcemap
from kwatra.blend import bands, blend
from kwatra.levels import Level
from kwatra.prepared import Prepared
from kwatra.reductions import mean
from kwatra.robust import rho, weight
from kwatra.search import cheapest
from kwatra.settings import Settings
from kwatra.terms import TermLike, Wish, resized, wish_of
from kwatra.windows import Grid, step_of

SETTLED = 1e-7
"""Squared distance (mean over a window, colors in [0, 1]) up to which a match counts as a verbatim copy."""


@dataclass(frozen=True)
class State:
    """Where the loop stands on a level: the image (C, *S), its matches (N,) or None before the first search."""

    image: Tensor
    matches: Tensor | None
    weights: Tensor
    iteration: int = 0
    energy: float = math.inf
    changed: float = 1.0


def coarse_shape(shape: Sequence[int], factors: Sequence[int]) -> tuple[int, ...]:
    """Shape of an output at a coarser resolution: blocks that the border cuts count as whole."""
    return tuple(-(-size // f) for size, f in zip(shape, factors, strict=True))


class Scene:
    """The exemplar's windows, the output's grid and the terms at one level.

    exemplar, shape and terms are those of the full resolution.
    """

    def __init__(
        self,
        exemplar: Prepared,
        shape: tuple[int, ...],
        terms: Sequence[TermLike],
        level: Level,
        settings: Settings,
        generator: torch.Generator,
    ) -> None:
        axes = len(shape)
        self.level, self.settings, self.generator = level, settings, generator
        self.factors = level.factors(axes)
        self.shape = coarse_shape(shape, self.factors)
        width = level.window(axes)
        self.source = exemplar.windows(self.factors, width, generator, settings.features)
        self.grid = Grid(self.shape, width, tuple(map(step_of, width)), settings.wrap, device=self.source.device)
        self.terms = [term.at(self.factors, self.shape) for term in terms]

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
            return State(resized(image, self.factors, self.shape), None, ones)
        if where is None:
            pick = torch.randint(len(self.source.numbers), (len(self.grid),), generator=self.generator)
            matches = self.source.numbers[pick.to(self.grid.device)]
        else:
            carried = where if same else sourcemap.carried(where, factors, self.factors, self.shape)
            matches = sourcemap.at_windows(self.grid, self.source, carried)
        if image is None or not same:
            image = blend(self.grid, self.source, matches, ones)
        return State(image, matches, ones)

    def step(self, state: State) -> tuple[State, dict[str, float | str]]:
        """One EM iteration: the next state, and its energies by name."""
        route = self.route(state.matches is not None)
        quadratics = [term.quadratic(state.image) for term in self.terms]
        matches, squared = self._search(state, route, wish_of(quadratics, state.image))
        weights = weight(squared, self.settings.r)
        image = blend(self.grid, self.source, matches, weights, quadratics, state.image)
        energies: dict[str, float] = {"texture": float(mean(rho(squared, self.settings.r)))}
        for term in self.terms:
            energies[term.name] = energies.get(term.name, 0.0) + term.energy(image)
        total = sum(energies.values())
        changed = 1.0 if state.matches is None else float((matches != state.matches).float().mean())
        row = {"route": route, "changed": changed, **energies, "total": total}
        return State(image, matches, weights, state.iteration + 1, total, changed), row

    def _search(self, state: State, route: str, wish: Wish | None) -> tuple[Tensor, Tensor]:
        """Best matches (N,) and their squared distances (N,). Windows that match without cost are not searched for."""
        coherent = None if state.matches is None else self._coherent(state.matches)
        found, distances = [], []
        for part, band in bands(self.grid, self.source.metric):
            near = None if coherent is None else coherent[part]
            windows = band.gather(state.image)
            wished = None if wish is None else (band.gather(wish.weight), band.gather(wish.value))
            number, squared = self._matched(windows, wished, near, route)
            found.append(number)
            distances.append(squared)
        return torch.cat(found), torch.cat(distances)

    def _matched(
        self, windows: Tensor, wished: tuple[Tensor, Tensor] | None, near: Tensor | None, route: str
    ) -> tuple[Tensor, Tensor]:
        """Best matches of windows (N, *width, C) and their squared distances; `near` are coherent candidates."""
        if near is None:
            return self._compared(windows, wished, self._candidates(windows, wished, None, route))
        number = near[:, 0].clone()
        squared = self.source.metric.squared(windows - self.source.windows(number))
        open_ = squared > SETTLED
        if wished is not None:
            open_ |= (wished[0] > 0).flatten(1).any(1)
        active = open_.nonzero()[:, 0]
        if len(active):
            windows = windows[active]
            wished = None if wished is None else (wished[0][active], wished[1][active])
            candidates = self._candidates(windows, wished, near[active], route)
            number[active], squared[active] = self._compared(windows, wished, candidates)
        return number, squared

    def _compared(
        self, windows: Tensor, wished: tuple[Tensor, Tensor] | None, candidates: Tensor
    ) -> tuple[Tensor, Tensor]:
        """The cheapest candidate of each window by exact cost (thesis equation 26)."""

        def cost(squared: Tensor, there: Tensor) -> Tensor:
            if wished is None:
                return squared
            return squared + (wished[0] * (there - wished[1]) ** 2).flatten(1).mean(1)

        return cheapest(self.source, windows, candidates, cost)

    def _coherent(self, matches: Tensor) -> Tensor:
        """Each window's match and its grid neighbors' matches, shifted: (N, 1 + 2n)."""
        columns = [matches]
        corners = self.source.corners(matches)
        for neighbor, shift in self.grid.neighbor_shifts():
            columns.append(self.source.snapped(corners[neighbor] + shift))
        return torch.stack(columns, 1)

    def _candidates(
        self, windows: Tensor, wished: tuple[Tensor, Tensor] | None, near: Tensor | None, route: str
    ) -> Tensor:
        """The most promising matches (N, k) of windows: the one they have first, then those estimated nearest.

        With a wish (w, c) one asks for what is nearest to (x + w c) / (1 + w): the minimum of both distances.
        """
        k = self.settings.candidates
        query = windows if wished is None else (windows + wished[0] * wished[1]) / (1 + wished[0])
        described = self.source.describe(query)
        if near is None:
            rest = self.source.nearest(described[0], k, route)
        elif route == "coherent":
            rest = near[:, 1:]
        else:
            rest = torch.cat([near[:, 1:], self.source.nearest(described[0], k, route)], 1)
        order = self.source.estimate(*described, rest).argsort(dim=1, stable=True)[:, :k]
        rest = rest.gather(1, order)
        return rest if near is None else torch.cat([near[:, :1], rest], 1)
