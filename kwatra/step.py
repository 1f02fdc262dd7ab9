"""Where an optimization stands: the one context that votes, layouts, terms and `between` are told."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from kwatra.exemplar import Exemplar
from kwatra.levels import Level
from kwatra.source import Source
from kwatra.windows import Grid, Layout, step_of


@dataclass(frozen=True, eq=False)
class Step:
    """An iteration of a level.

    level: the level at work; number: which one, from 0; iteration: which of its iterations, from 1. factors: how many
    times coarser its pixels are than the output's, per axis. shape: spatial shape S of the image here. wraps: along
    which axes the image is periodic. source: the windows that may be copied. exemplar: at this resolution, None where
    windows come from none. mask: boolean (*S), True where texture belongs, None where it does everywhere. generator:
    the optimization's only randomness. map: see `where`. image (C, *S): as it is; None before there is one.
    """

    level: Level
    number: int
    iteration: int
    factors: tuple[int, ...]
    shape: tuple[int, ...]
    wraps: tuple[bool, ...]
    source: Source
    exemplar: Exemplar | None
    mask: Tensor | None
    generator: torch.Generator
    map: Callable[[], Tensor | None] = lambda: None
    image: Tensor | None = None

    @cached_property
    def where(self) -> Tensor | None:
        """The source map (n, *S) of the image as it is, canvas coordinates at this resolution; None without one."""
        return self.map()

    @property
    def width(self) -> tuple[int, ...]:
        """Pixels of a window along each axis."""
        return tuple(self.source.metric.weight.shape[:-1])


def regular(step: Step) -> Layout:
    """Windows on a grid, a quarter of their width apart (thesis 5.1)."""
    return Grid(step.shape, step.width, tuple(map(step_of, step.width)), step.wraps, device=step.source.numbers.device)
