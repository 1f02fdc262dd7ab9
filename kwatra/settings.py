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
class Blocks:
    """The blocks of a start, see `kwatra.pieces`.

    size: their size as a share of the exemplar's, in (0, 1]. usage: how strongly the aligned start avoids much-used
    parts of the exemplar, >= 0. seams: of how many blocks it compares the seams.
    """

    size: float = 0.5
    usage: float = 0.5
    seams: int = 6

    def __post_init__(self) -> None:
        if not 0 < self.size <= 1:
            raise InputError(f"the blocks' size is {self.size}; it is a share of the exemplar's in (0, 1]")
        if not (0 <= self.usage < math.inf):
            raise InputError(f"the blocks' usage is {self.usage}; it is finite and >= 0")
        if self.seams < 1:
            raise InputError(f"the blocks' seams are {self.seams}; at least 1 is compared")


@dataclass(frozen=True)
class Search:
    """How windows are looked up.

    candidates: how many matches are compared exactly. exact_pairs: up to so many pairs of output and exemplar windows
    the search is exact where a level leaves the route open; beyond, it is coherent or approximate.
    """

    candidates: int = 3
    exact_pairs: int = 1 << 26

    def __post_init__(self) -> None:
        if self.candidates < 1 or self.exact_pairs < 0:
            raise InputError(
                f"the search has {self.candidates} candidates and {self.exact_pairs} exact pairs; give at least 1 "
                "candidate, and 0 pairs or more"
            )


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
    in time). features: linear features psi compared beside color. start: "aligned" (blocks that continue each other),
    "blocks" (blocks at random), "windows" (the average of random windows, as in the thesis) or "terms" (of windows that
    please the terms alone, thesis 7.1). blocks: those of the first two. iterations: per planned level. search: how
    windows are looked up. vote: what the windows that cover a pixel make of it, see `kwatra.steps.votes`. layout: where
    windows lie, told the `Step`; asked anew for every iteration. solver: how far a blend without a closed form is
    solved.
    """

    levels: tuple[Level, ...] | None = None
    r: float = 0.8
    wrap: bool | tuple[bool, ...] = False
    features: tuple[Feature, ...] = ()
    start: str = "aligned"
    blocks: Blocks = Blocks()
    iterations: int = 4
    search: Search = Search()
    vote: Vote = mean
    layout: Callable[[Step], Layout] = regular
    solver: Solver = Solver()

    def __post_init__(self) -> None:
        if not 0 < self.r <= 2:
            raise InputError(f"r is {self.r}; the robust exponent lies in (0, 2]")
        if self.start not in STARTS:
            raise InputError(f"start is {self.start!r}; allowed are {', '.join(STARTS)}")
        if self.levels is not None and not self.levels:
            raise InputError("levels is empty; give at least one level, or None to have them planned")
        if self.iterations < 1:
            raise InputError(f"iterations is {self.iterations}; there is at least 1")
