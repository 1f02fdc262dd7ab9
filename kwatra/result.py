"""What an optimization returns, and what it tells on the way."""

from dataclasses import dataclass

from torch import Tensor

Row = dict[str, float | int | str]


@dataclass(frozen=True)
class Stage:
    """What a level left: its number, factor and width, and the image (C, *S) at its own resolution."""

    level: int
    factor: int
    width: int
    image: Tensor


@dataclass(frozen=True)
class Progress:
    """Given to the callback after every iteration: share of all work done (0 to 1), where, energy, image so far.

    attempt, tries: which run this is, from 1, of how many of which the best is kept. Where only what is begun with is
    tried, it is given after each try, too, as iteration 0, with the figure that it is ranked by for its energy.
    Iteration 0 with fraction 1 tells that nothing was left to iterate.
    """

    fraction: float
    level: int
    iteration: int
    energy: float
    image: Tensor
    attempt: int = 1
    tries: int = 1


@dataclass(frozen=True)
class Result:
    """What an optimization returns.

    image (C, *S). source (1 + n, *S) int64: for each pixel the exemplar image it comes from and the pixel there; the
    image is -1 for pixels that were given or are masked and so come from none. where (n, *S) int64: the same pixel on
    the exemplar's canvas.
    energies: one row per iteration with level, factor, width, iteration, route, changed (share of matches), texture,
    each term by name, total, and residual (what the blend's solver left over, as a share of the right side; missing
    where the blend is exact). stages: the image after each level. Both are empty where nothing is left to iterate, as
    where the exemplar goes on by itself. stopped: why the last level ended.
    """

    image: Tensor
    source: Tensor
    where: Tensor
    energies: list[Row]
    stages: list[Stage]
    stopped: str
