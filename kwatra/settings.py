"""How to optimize: the settings, validated in one place before any work starts."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from kwatra.base import InputError
from kwatra.levels import Level
from kwatra.step import Step, regular
from kwatra.steps.votes import Vote, mean
from kwatra.windows import Feature, Layout


@dataclass(frozen=True)
class Solver:
    """How far a blend that has no closed form (features, terms that are not diagonal) is solved.

    tolerance: until this share of the right side is left over, in (0, 1); steps: or after so many.
    `Result.energies` tells the residual reached.
    """

    tolerance: float = 1e-4
    steps: int = 500

    def __post_init__(self) -> None:
        if not (0 < self.tolerance < 1) or self.steps < 1:
            raise InputError(
                f"the solver has a tolerance of {self.tolerance} and {self.steps} steps; the residual lies in (0, 1) "
                "and there is at least 1 step"
            )


@dataclass(frozen=True)
class Settings:
    """How to optimize; the defaults suit most textures.

    levels: coarse to fine; None plans them from the exemplar. r: exponent of the robust energy, in (0, 2].
    wrap: windows run over the border, so that the output tiles; one answer, or one per axis (a video that loops wraps
    in time). features: linear features psi compared beside color. block: how large the blocks of a start are, as a
    share of the exemplar, in (0, 1]. seams: of how many blocks an aligned start compares the seams. even: how much
    it counts in a start that all of the exemplar is shown as often, >= 0; with 0 fewer elements are cut, and some
    never shown. iterations: per planned level. vote: what the windows that cover a pixel make of it, see
    `kwatra.steps.votes`. layout: where windows lie, told the `Step`; asked anew for every iteration. solver: how far a
    blend without a closed form is solved.
    """

    levels: tuple[Level, ...] | None = None
    r: float = 0.8
    wrap: bool | tuple[bool, ...] = False
    features: tuple[Feature, ...] = ()
    block: float = 0.5
    seams: int = 6
    even: float = 1.0
    iterations: int = 4
    vote: Vote = mean
    layout: Callable[[Step], Layout] = regular
    solver: Solver = Solver()

    def __post_init__(self) -> None:
        if not 0 < self.r <= 2:
            raise InputError(f"r is {self.r}; the robust exponent lies in (0, 2]")
        if not 0 < self.block <= 1:
            raise InputError(f"block is {self.block}; it is a share of the exemplar in (0, 1]")
        if self.levels is not None and not self.levels:
            raise InputError("levels is empty; give at least one level, or None to have them planned")
        if not 0 <= self.even < math.inf:
            raise InputError(
                f"even is {self.even}; what even use of the exemplar counts is 0 or more, and 1 by default"
            )
        if min(self.iterations, self.seams) < 1:
            raise InputError(f"iterations is {self.iterations} and seams {self.seams}; each is at least 1")
