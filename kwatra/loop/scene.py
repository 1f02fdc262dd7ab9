"""One level of an optimization at work: enter it with what the level before left, then iterate.

An iteration is `step`: search (M), robust weights, blend (E) - thesis algorithms 1 and 2 with section 5.2.
"""

import math
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import Solution, by_our_threads, enlarged, mean, total
from kwatra.loop.task import Task
from kwatra.result import Row
from kwatra.source import Placed, sourcemap
from kwatra.step import Step
from kwatra.steps import Ballot, Matching, Replays, Wants, blend, fits, rho, weight
from kwatra.terms import Charge, PlaceCharge, Quadratic, wish_of
from kwatra.windows import Layout

EXACT_PAIRS = 1 << 26
"""Up to so many pairs of output and exemplar windows the search is exact where a level leaves the route open: a bound
on time. With a sixteenth of it ten images of 128x128 px score the same by fast, in .25 s in place of .35; but of what a
guide asks .23 of its range is missed in place of .18."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where the loop stands on a level: the image (C, *S), and the matches (N,) of a layout's windows.

    matches: None before the first search. weights (N,): robust weights of the windows.
    """

    image: Tensor
    layout: Layout
    matches: Tensor | None
    weights: Tensor
    iteration: int = 0
    energy: float = math.inf
    changed: float = 1.0


class Scene:
    """Level `number` of a task: the source's windows, the output's layout and what is asked of it."""

    def __init__(self, task: Task, number: int) -> None:
        self.task, self.number, self.level = task, number, task.levels[number]
        axes = len(task.shape)
        self.factors = self.level.factors(axes)
        width, features = self.level.window(axes), task.settings.features
        self.source = task.texture.source(self.factors, width, task.generator, features)
        self.exemplar = self.source.exemplar if isinstance(self.source, Placed) else None
        self.controls = task.controls(self.factors)
        self.shape = self.controls.shape
        self.places = [] if self.exemplar is None else self.controls.place_charges(self.exemplar, width)
        self._matching: Matching | None = None

    def context(self, iteration: int, estimate: Estimate | None = None) -> Step:
        """What votes, layouts, terms and `between` are told in an iteration."""
        mask = None if self.controls.mask is None else self.controls.mask[0]
        return Step(
            self.level, self.number, iteration, self.factors, self.shape, self.task.wraps, self.source,
            self.exemplar, mask, self.task.generator, lambda: None if estimate is None else self.where(estimate),
            None if estimate is None else estimate.image,
        )  # fmt: skip

    def where(self, estimate: Estimate) -> Tensor | None:
        """The source map (n, *S) of an estimate; None where windows have no place, or nothing is matched yet."""
        if estimate.matches is None or not isinstance(self.source, Placed):
            return None
        return sourcemap.winners(estimate.layout, self.source, estimate.matches, estimate.weights)

    def enter(self, image: Tensor | None, where: Tensor | None, factors: Sequence[int]) -> Estimate:
        """The estimate with which this level begins, from an image, a source map, both or neither.

        factors: the resolution that both have. With a map of another resolution the image is made anew from it.
        """
        layout = self.task.settings.layout(self.context(0))
        ones = torch.ones(len(layout), dtype=torch.float32, device=layout.device)
        same = tuple(factors) == self.factors
        if where is None and image is not None:
            return Estimate(self._fitted(image, factors), layout, None, ones)
        with self.sharing(layout, where is not None):
            matches = self._begun(layout) if where is None else self._carried(layout, where, factors)
            if image is None or not same:
                image = self._blended(Ballot(layout, self.source, matches, ones)).x
        return Estimate(image, layout, matches, ones)

    def _fitted(self, image: Tensor, factors: Sequence[int]) -> Tensor:
        """An image of the full or of a coarser resolution at this one."""
        if max(factors) == 1:
            return self.controls.shrunk(image)
        return self.controls.held(enlarged(image, self.shape))

    def _begun(self, layout: Layout) -> Tensor:
        """Matches to begin with where nothing is there: random windows, or those that please the terms."""
        if self.task.start == "terms":
            step = self.context(0)
            blank = self.controls.blank()
            wants = self._wants(self.controls.quadratics(blank), blank, self.controls.charges(None, step))
            return self._matches_of(layout).by_terms(wants, blank, self.task.generator)
        pick = torch.randint(len(self.source.numbers), (len(layout),), generator=self.task.generator)
        return self.source.numbers[pick.to(self.source.numbers.device)]

    def _carried(self, layout: Layout, where: Tensor, factors: Sequence[int]) -> Tensor:
        assert isinstance(self.source, Placed)
        if tuple(factors) != self.factors:
            where = sourcemap.carried(where, factors, self.factors, self.shape)
        return sourcemap.at_windows(layout, self.source, where)

    def _matches_of(self, layout: Layout) -> Matching:
        """The search for a layout, kept while that is the same."""
        if self._matching is None or self._matching.layout != layout:
            self._matching = Matching(self.source, layout, self.controls.given)
        return self._matching

    def _wants(
        self,
        quadratics: list[Quadratic],
        x: Tensor,
        charges: Sequence[Charge | None],
        replays: Sequence[PlaceCharge] = (),
    ) -> Wants:
        """What the search heeds: a term's own charges, or else the wish that follows from its quadratic, and places."""
        silent = [q for q, charge in zip(quadratics, charges, strict=True) if charge is None]
        places: list[PlaceCharge] = [*(charge for _, charge in self.places), *replays]
        return Wants(wish_of(silent, x), [charge for charge in charges if charge is not None], places)

    def _replays(self, estimate: Estimate) -> list[Replays]:
        """What long copies in time cost a video that stays in its place."""
        if len(self.shape) < 3 or not self.places or estimate.matches is None:
            return []
        assert isinstance(self.source, Placed)
        return [Replays(estimate.layout, self.source, estimate.matches)]

    def route(self, inherited: bool, windows: int) -> str:
        """How to search: exactly while that is cheap, else by coherence or, with nothing to go by, approximately."""
        wanted = self.level.route
        if wanted is not None and (inherited or wanted != "coherent"):
            return wanted
        if windows * len(self.source.numbers) <= EXACT_PAIRS:
            return "exact"
        # coherence goes by copies that are there already; random windows are none
        copied = inherited and self.task.start != "windows" and isinstance(self.source, Placed)
        return "coherent" if copied else "approximate"

    def sharing(self, layout: Layout, inherited: bool) -> AbstractContextManager[None]:
        """Whose threads search and blend a layout: ours where compiled loops do what takes long, else torch's.

        They do for stills that nothing steers and that go by coherence; to search an index, and for videos, tensors do.
        """
        steered = self.controls.given is not None or len(self.task.terms) > 0
        if steered or len(self.shape) > 2 or not fits(self.source):
            return nullcontext()
        return by_our_threads() if self.route(inherited, len(layout)) == "coherent" else nullcontext()

    def step(self, estimate: Estimate) -> tuple[Estimate, Row]:
        """One EM iteration: the next estimate, and its energies by name."""
        settings = self.task.settings
        context = self.context(estimate.iteration + 1, estimate)
        estimate = self._laid_out(estimate, context)
        layout, inherited = estimate.layout, estimate.matches is not None
        matching, route = self._matches_of(layout), self.route(inherited, len(layout))
        quadratics = self.controls.quadratics(estimate.image)
        charges = self.controls.charges(estimate.image, context)
        wants = self._wants(quadratics, estimate.image, charges, self._replays(estimate))
        found = matching.best(estimate.image, estimate.matches, wants, route, self.level.route is None)
        matches, weights = found.matches, weight(found.free, settings.r)
        if matching.active is not None:
            weights = weights * matching.active
        solution = self._blended(Ballot(layout, self.source, matches, weights), quadratics, estimate.image)
        image = solution.x
        energies = {"texture": self._mean(rho(found.squared, settings.r), matching.active)}
        for name, value in self.controls.energies(image):
            energies[name] = energies.get(name, 0.0) + value
        if isinstance(self.source, Placed):
            for name, charge in self.places:
                away = charge(layout.corners, self.source.corners(matches)[:, None])[:, 0]
                energies[name] = energies.get(name, 0.0) + self._mean(away, matching.active)
        sum_ = sum(energies.values())
        before = estimate.matches
        changed = 1.0 if before is None else self._mean((matches != before).float(), matching.active)
        row: Row = {"route": route, "changed": changed, **energies, "total": sum_}
        if solution.residual > 0:
            row["residual"] = solution.residual
        return Estimate(image, layout, matches, weights, estimate.iteration + 1, sum_, changed), row

    def _blended(self, ballot: Ballot, quadratics: Sequence[Quadratic] = (), start: Tensor | None = None) -> Solution:
        """The blend on this level, solved as far as the settings ask."""
        s = self.task.settings
        return blend(ballot, quadratics, start, self.controls.given, s.vote, s.solver.tolerance, s.solver.steps)

    def _laid_out(self, estimate: Estimate, step: Step) -> Estimate:
        """The estimate on the layout of this iteration; where windows move, their matches come from the source map."""
        layout = self.task.settings.layout(step)
        if layout == estimate.layout:
            return estimate
        ones = torch.ones(len(layout), dtype=torch.float32, device=layout.device)
        matches = None
        if step.where is not None and isinstance(self.source, Placed):
            matches = sourcemap.at_windows(layout, self.source, step.where)
        return Estimate(estimate.image, layout, matches, ones, estimate.iteration, estimate.energy, estimate.changed)

    def _mean(self, values: Tensor, active: Tensor | None) -> float:
        """Mean of values (N,) over the windows with a free pixel, 0 where there are none."""
        if active is None:
            return float(mean(values))
        return float(total(values * active)) / max(int(active.sum()), 1)
