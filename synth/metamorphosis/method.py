"""What every metamorphosis takes and gives: two exemplars and times, and a film.

A method is a callable: `method(pair, times, seed, report) -> Film`. Its options are its own settings, bound before
(`functools.partial`, or a frozen dataclass with `__call__`). No method imports another.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import torch
from torch import Tensor

from kwatra.result import Row

Report = Callable[[str, float], None]
"""Told what is being done and how much of all work is done, 0 to 1."""


@dataclass(frozen=True)
class Pair:
    """Two exemplars with the same number of channels.

    a (C, H, W) and b (C, h, w): float32 in [0, 1]. features_a (K, H, W) and features_b (K, h, w): maps of what is a
    feature in each, in [0, 1]; None where none are given. tile: both textures repeat in both directions.
    """

    a: Tensor
    b: Tensor
    features_a: Tensor | None = None
    features_b: Tensor | None = None
    tile: bool = False

    def to(self, device: torch.device | str) -> "Pair":
        """The same pair on another device."""
        a, b, features_a, features_b = (
            None if tensor is None else tensor.to(device)
            for tensor in (self.a, self.b, self.features_a, self.features_b)
        )
        assert a is not None
        assert b is not None
        return Pair(a, b, features_a, features_b, self.tile)


@dataclass(frozen=True)
class Film:
    """The frames of a metamorphosis, and what the method knows of the way.

    frames: one (C, H, W) in [0, 1] per time. times: 0 (A) to 1 (B). velocity (N, 2, H, W): forward flows, x first, px
    per step of 1 / N, for methods that move pixels; None for others. energies: one row per iteration. remarks:
    sentences for a person, such as how sure a method is, or why it stopped.
    """

    frames: tuple[Tensor, ...]
    times: tuple[float, ...]
    velocity: Tensor | None = None
    energies: list[Row] = field(default_factory=list)
    remarks: tuple[str, ...] = ()


class Method(Protocol):
    """What `synth.morph` calls; see the module."""

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair at times in [0, 1]; InputError for pairs that the method cannot do."""
