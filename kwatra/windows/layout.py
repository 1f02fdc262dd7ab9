"""Where the windows of an output lie: what the engine asks of them, be they on a grid or free."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import torch
from torch import Tensor

from kwatra.base import InputError


def per_axis(wrap: bool | Sequence[bool], axes: int) -> tuple[bool, ...]:
    """Along which axes an output is periodic, of one answer for all or one for each; InputError for another number."""
    wraps = (wrap,) * axes if isinstance(wrap, bool) else tuple(wrap)
    if len(wraps) != axes:
        raise InputError(f"wrap is {wrap}; give one answer for all {axes} axes, or {axes}")
    return wraps


class Covering(NamedTuple):
    """One window for every pixel of an output of shape S, and the pixel's place in it.

    window: number, broadcastable to S. inside: per axis the place, broadcastable to S. there: False where no window is
    left to name and an earlier one is named again, broadcastable to S.
    """

    window: Tensor
    inside: tuple[Tensor, ...]
    there: Tensor


class Layout(Protocol):
    """Windows of `width` on an output of spatial `shape` (n axes each), which may be periodic along some axes."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Spatial shape S of the output."""

    @property
    def width(self) -> tuple[int, ...]:
        """Pixels of a window along each axis."""

    @property
    def wraps(self) -> tuple[bool, ...]:
        """Along which axes windows run over the border."""

    @property
    def device(self) -> torch.device | str:
        """Where its tensors are."""

    @property
    def corners(self) -> Tensor:
        """First pixel of every window, (N, n)."""

    def __len__(self) -> int:
        """Number of windows N."""

    def bands(self, most: int) -> Iterator["Layout"]:
        """The windows in order, in parts of about `most`: bounds the memory of a pass."""

    def gather(self, image: Tensor) -> Tensor:
        """All windows of an image (C, *S), as (N, *width, C)."""

    def scatter(self, windows: Tensor, into: Tensor | None = None) -> Tensor:
        """The transpose of `gather`: windows (N, *width, C) summed into an image (C, *S).

        into: an image to which they are added, in place, instead of a new one.
        """

    def neighbor_shifts(self, part: slice = slice(None)) -> Iterator[tuple[Tensor, Tensor]]:
        """For each of 2n neighbors of every window: its number (N,), and the window's corner minus its (N, n).

        part: of which windows, in steps of 1.
        """

    def coverings(self) -> Iterator[Covering]:
        """All windows that cover each pixel, one at a time."""
