"""What the engine asks of a source: a set of windows to copy from.

A window is known by its number. Windows of an exemplar have a place on its canvas, made-up ones have none; what needs
places (coherent candidates, source maps, whole copies) asks for a `Placed` source and is left out without one.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import torch
from torch import Tensor

from kwatra.exemplar import Exemplar
from kwatra.windows import Metric

ROUTES = ("exact", "approximate", "coherent")
"""How matches are searched: in all windows, in those of like descriptors, or by coherence alone."""

CHUNK = 1 << 21
"""Values in one temporary of a pass over windows: bounds its memory to a few times 8 MiB.

Larger ones leave the cache, and malloc gives their pages back each time: with 2^24 a 1024x1024 image took a third
longer, half of all its time in the system."""

_CHUNK_ELSEWHERE = 1 << 26
"""The same of a graphics card, which has few caches and many cores: a video of 160x128x30 took 3.0 s on an H100 with
2^21, 1.9 with this."""


def chunk(device: torch.device | str) -> int:
    """How many values one temporary of a pass over windows has on a device."""
    return CHUNK if torch.device(device).type == "cpu" else _CHUNK_ELSEWHERE


class Description(NamedTuple):
    """Windows in short: descriptor (N, dims), principal components; remainder (N,), the length they leave out."""

    descriptor: Tensor
    remainder: Tensor


class Source(Protocol):
    """Windows (*width, C) that may be copied, and the search among them.

    numbers (M,): those that may be copied, ascending; others below `count` may be described but not used.
    """

    metric: Metric
    numbers: Tensor

    @property
    def count(self) -> int:
        """One more than the largest number."""

    def windows(self, numbers: Tensor) -> Tensor:
        """The windows of these numbers (N,): (N, *width, C)."""

    def values(self, numbers: Tensor, inside: Sequence[Tensor]) -> Tensor:
        """For numbers (*S), the value of each window at the place `inside`, n tensors (*S): (C, *S)."""

    def describe(self, windows: Tensor) -> Description:
        """Any windows (N, *width, C) in short, as the source's own are described."""

    def estimate(self, described: Description, numbers: Tensor) -> Tensor:
        """Estimated squared distances (N, k) between described windows and the source's of these numbers (N, k)."""

    def nearest(self, described: Description, k: int, route: str) -> Tensor:
        """Numbers (N, <= k) of the source's windows nearest to described ones, nearest first; route: one of ROUTES."""

    def completed(self, windows: Tensor, present: Tensor) -> Tensor:
        """Windows (N, *width, C) whose values where `present` (N, *width, 1) is 0 are expected from the others."""


@runtime_checkable
class Placed(Source, Protocol):
    """A source whose windows lie on the canvas of an exemplar."""

    exemplar: Exemplar

    def corners(self, numbers: Tensor) -> Tensor:
        """First pixels (..., n) on the canvas of windows of these numbers (...)."""

    def snapped(self, corners: Tensor) -> Tensor:
        """Numbers (...) of the windows that may be copied nearest to corners (..., n), which may lie anywhere."""
