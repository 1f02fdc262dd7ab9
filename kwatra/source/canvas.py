"""All windows of an exemplar of one width, as a source.

A window's number is its corner (first pixel) counted row by row over the canvas positions S - width + 1. Describing
every window is a convolution of the canvas with the principal components, so no table of windows is ever stored.
"""

import math
from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from kwatra.base import CONVOLUTION, InputError, nearest_known
from kwatra.exemplar import Exemplar
from kwatra.source.described import DIMS, Described
from kwatra.source.protocol import chunk
from kwatra.windows import Feature, Metric, channels_last, windows_at

TOGETHER, OVERLAPS = 2**22, 8
"""So many components of windows are found at once, 16 MiB, or those along so many times a window's width: the pages of
larger temporaries are given back each time. Of twelve megapixels that takes 9 s, of 2^25 components at once 12, and
17 of all."""


class SourceWindows(Described):
    """The windows of an exemplar; InputError where none of this width fits into it."""

    def __init__(
        self,
        exemplar: Exemplar,
        width: Sequence[int],
        generator: torch.Generator,
        dims: int = DIMS,
        features: Sequence[Feature] = (),
    ) -> None:
        self.exemplar, self.width = exemplar, tuple(width)
        valid = exemplar.corners(self.width)
        if not bool(valid.any()):
            size = "x".join(map(str, self.width))
            raise InputError(f"no {size} window fits into the exemplar; choose smaller windows or a larger exemplar")
        self.positions = tuple(valid.shape)
        device = exemplar.canvas.device
        self.pixels = channels_last(exemplar.canvas)
        self._place = torch.tensor([math.prod(self.positions[i + 1 :]) for i in range(valid.ndim)], device=device)
        self._shape = torch.tensor(self.positions, device=device)
        # the number of the nearest position where a window may start, for every position (count,)
        self.snap = self.number(nearest_known(valid).flatten(1).T)
        metric = Metric(self.width, exemplar.weights, features)
        super().__init__(metric, valid.flatten().nonzero()[:, 0], dims, generator)

    @property
    def count(self) -> int:
        """See `Source.count`."""
        return math.prod(self.positions)

    def number(self, corners: Tensor) -> Tensor:
        """Window numbers of corners (..., n) that are positions."""
        number = torch.zeros_like(corners[..., 0])
        for corner, step in zip(corners.unbind(-1), self._place.tolist(), strict=True):
            number.add_(corner, alpha=step)
        return number

    def corners(self, numbers: Tensor) -> Tensor:
        """See `Placed.corners`."""
        corners = numbers.new_empty(*numbers.shape, len(self.positions))
        for along, step in zip(corners.unbind(-1), self._place.tolist(), strict=True):
            along.copy_(numbers // step if step > 1 else numbers)
            numbers = numbers - along * step
        return corners

    def snapped(self, corners: Tensor) -> Tensor:
        """See `Placed.snapped`."""
        return self.snap[self.number(corners.clamp(torch.zeros_like(self._shape), self._shape - 1))]

    def windows(self, numbers: Tensor) -> Tensor:
        """See `Source.windows`."""
        return windows_at(self.pixels, self.corners(numbers), self.width)

    def values(self, numbers: Tensor, inside: Sequence[Tensor]) -> Tensor:
        """See `Source.values`."""
        place = [c + i for c, i in zip(self.corners(numbers).unbind(-1), inside, strict=True)]
        return self.pixels[tuple(place)].movedim(-1, 0)

    def projections(self, basis: Tensor, mean: Tensor) -> Iterator[tuple[Tensor, Tensor]]:
        """See `Described.projections`."""
        components = self.metric.transposed(basis.T.contiguous())
        lengths = None if self.metric.plain else self._lengths(mean)
        line = math.prod(self.positions[1:])
        lines = max(TOGETHER // (line * len(components)), OVERLAPS * self.width[0])
        for first in range(0, self.positions[0], lines):
            part = self.exemplar.canvas[:, first : first + lines + self.width[0] - 1]
            along = self._correlated(part, components).T
            if lengths is None:
                yield along, self._plain_lengths(part, mean)
            else:
                yield along, lengths[first * line : first * line + len(along)]

    def _correlated(self, part: Tensor, kernels: Tensor) -> Tensor:
        """Inner products (K, positions) of window-shaped kernels (K, *width, C) with every window of a part (C, *S)."""
        return CONVOLUTION[len(self.width)](part[None], kernels.movedim(-1, 1).contiguous())[0].flatten(1)

    def _plain_lengths(self, part: Tensor, mean: Tensor) -> Tensor:
        """|E z - mean|^2 for the window at every position of a part (C, *S) of the canvas, where E has no features."""
        square = self._correlated(part.square(), self.metric.weight[None])[0]
        return square - 2 * self._correlated(part, self.metric.transposed(mean[None]))[0] + (mean**2).sum()

    def _lengths(self, mean: Tensor) -> Tensor:
        """|E z - mean|^2 for the window at every position that counts, 0 elsewhere."""
        lengths = mean.new_zeros(self.count)
        for numbers in self.numbers.split(max(chunk(mean.device) // mean.numel(), 1)):
            lengths[numbers] = (self.metric.embed(self.windows(numbers)) - mean).square().sum(1)
        return lengths
