"""How to optimize: the settings, validated in one place before any work starts."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from kwatra.base import InputError
from kwatra.levels import Level
from kwatra.steps.step import Step, regular
from kwatra.steps.votes import Vote, mean
from kwatra.windows import Feature, Layout

STARTS = ("aligned", "blocks", "windows", "terms")


@dataclass(frozen=True)
class Settings:
    """How to optimize; the defaults suit most textures.

    levels: coarse to fine; None plans them from the exemplar. r: exponent of the robust energy, in (0, 2].
    wrap: windows run over the border, so that the output tiles; one answer, or one per axis (a video that loops wraps
    in time). features: linear features psi compared beside color. start: "aligned" (blocks that continue each other),
    "blocks" (blocks at random), "windows" (the average of random windows, as in the thesis) or "terms" (of windows that
    please the terms alone, thesis 7.1). block: size of start blocks as a share of the exemplar's. usage: how strongly
    the aligned start avoids much-used parts of the exemplar. seams: of how many blocks it compares the seams.
    iterations: per planned level. candidates: how many matches are compared exactly. exact_pairs: up to so many pairs
    of output and exemplar windows the search is exact where a level leaves the route open; beyond, it is coherent or
    approximate. tolerance: a level ends when fewer than this share of the matches change. vote: what the windows that
    cover a pixel make of it, see `kwatra.steps.votes`. layout: where windows lie, told the `Step`; asked anew for every
    iteration. solver_tolerance and solver_steps: where the blend has no closed form (features, terms that are not
    diagonal) it is solved until this share of the right side is left over, or after so many steps; `Result.energies`
    tells the residual reached.
    """

    levels: tuple[Level, ...] | None = None
    r: float = 0.8
    wrap: bool | tuple[bool, ...] = False
    features: tuple[Feature, ...] = ()
    start: str = "aligned"
    block: float = 0.5
    usage: float = 0.35
    seams: int = 6
    iterations: int = 4
    candidates: int = 3
    exact_pairs: int = 1 << 26
    tolerance: float = 0.005
    vote: Vote = mean
    layout: Callable[[Step], Layout] = regular
    solver_tolerance: float = 1e-4
    solver_steps: int = 500

    def __post_init__(self) -> None:
        if not 0 < self.r <= 2:
            raise InputError(f"r is {self.r}; the robust exponent lies in (0, 2]")
        if self.start not in STARTS:
            raise InputError(f"start is {self.start!r}; allowed are {', '.join(STARTS)}")
        if not 0 < self.block <= 1:
            raise InputError(f"block is {self.block}; it is a share of the exemplar in (0, 1]")
        if not (0 <= self.usage < math.inf):
            raise InputError(f"usage is {self.usage}; it is finite and >= 0")
        if self.levels is not None and not self.levels:
            raise InputError("levels is empty; give at least one level, or None to have them planned")
        if min(self.iterations, self.candidates, self.seams) < 1:
            raise InputError(
                f"iterations is {self.iterations}, candidates {self.candidates} and seams {self.seams}; each is at "
                "least 1"
            )
        if not (0 < self.solver_tolerance < 1) or self.solver_steps < 1:
            raise InputError(
                f"solver_tolerance is {self.solver_tolerance} and solver_steps {self.solver_steps}; the residual lies "
                "in (0, 1) and there is at least 1 step"
            )
