"""What every metamorphosis takes and gives: two exemplars and times, and a film.

A method is a callable: `method(pair, times, seed, report) -> Film`; times are in order. Its options are its own
settings, bound before: it is a frozen dataclass with `__call__`. No method imports another.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, TypeVar, overload

import torch
from torch import Tensor

from kwatra.result import Row

Report = Callable[[str, float], None]
"""Told what is being done and how much of all work is done, 0 to 1."""


def silent(what: str, part: float) -> None:
    """A report that nobody is told."""


@dataclass(frozen=True)
class Pair:
    """Two exemplars with the same number of channels.

    a (C, H, W) and b (C, h, w): float32 in [0, 1]. features_a (K, H, W) and features_b (K, h, w): maps of what is a
    feature in each, in [0, 1]; None where none are given. tile: both textures repeat in both directions. extremes: what
    0 and 1 of a and b are in the images as they were given.
    """

    a: Tensor
    b: Tensor
    features_a: Tensor | None = None
    features_b: Tensor | None = None
    tile: bool = False
    extremes: tuple[float, float] = (0.0, 1.0)

    def to(self, device: torch.device | str) -> "Pair":
        """The same pair on another device."""
        a, b, features_a, features_b = (
            None if tensor is None else tensor.to(device)
            for tensor in (self.a, self.b, self.features_a, self.features_b)
        )
        assert a is not None
        assert b is not None
        return replace(self, a=a, b=b, features_a=features_a, features_b=features_b)


Item = TypeVar("Item")


class Frames(Sequence[Item]):
    """Frames that are made one by one, in order, when one of them is first looked at, and kept."""

    def __init__(self, making: Iterable[Item], count: int) -> None:
        self._making, self._count = iter(making), count
        self._made: list[Item] = []

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Item: ...

    @overload
    def __getitem__(self, index: slice) -> list[Item]: ...

    def __getitem__(self, index: int | slice) -> Item | list[Item]:
        if isinstance(index, slice):
            return [self[number] for number in range(self._count)[index]]
        number = range(self._count)[index]
        while len(self._made) <= number:
            self._made.append(next(self._making))
        return self._made[number]

    def once(self) -> Iterator[Item]:
        """Each frame in turn, once: those not yet made are not kept, so that a film may be longer than memory."""
        yield from self._made
        yield from self._making


@dataclass(frozen=True)
class Film:
    """The frames of a metamorphosis, and what the method knows of the way.

    frames: one (C, H, W) in [0, 1] per time, may be made as they are looked at. times: 0 (A) to 1 (B). motion: the
    velocity, or what makes it when it is first asked for; None for methods that move no pixels. energies: one row per
    iteration. remarks: sentences for a person, such as how sure a method is, or why it stopped. masks: where the
    elements of A and of B are, booleans (H, W), for methods that are told or look; features: what is a feature in each.
    """

    frames: Sequence[Tensor]
    times: tuple[float, ...]
    motion: Tensor | Callable[[], Tensor] | None = None
    energies: list[Row] = field(default_factory=list)
    remarks: tuple[str, ...] = ()
    masks: tuple[Tensor, Tensor] | None = None
    features: tuple[Tensor, ...] | None = None

    @cached_property
    def velocity(self) -> Tensor | None:
        """Forward flows (N, 2, H, W), x first, px per step of 1 / N."""
        return self.motion if self.motion is None or isinstance(self.motion, Tensor) else self.motion()


class Method(Protocol):
    """What `synth.morph` calls; see the module."""

    def __call__(self, pair: Pair, times: Sequence[float], seed: int, report: Report) -> Film:
        """The film of a pair at times in [0, 1]; InputError for pairs that the method cannot do."""

    def of_size(self, size: tuple[int, int]) -> "Method | None":
        """The method with frames of a size (height, width); None where the pair must have it, as with most."""
        return None
