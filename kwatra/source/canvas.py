"""All windows of an exemplar of one width, as a source.

A window's number is its corner (first pixel) counted row by row over the canvas positions S - width + 1. Describing
every window is a convolution of the canvas with the principal components, so no table of windows is ever stored.
"""

import math
from collections.abc import Sequence

import torch
from torch import Tensor

from kwatra.base import CONVOLUTION, InputError, nearest_known
from kwatra.exemplar import Exemplar
from kwatra.source.described import DIMS, Described
from kwatra.source.protocol import chunk
from kwatra.windows import Feature, Metric, channels_last, windows_at


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
        # the nearest position where a window may start, for every position
        self._snap = self.number(nearest_known(valid).flatten(1).T)
        metric = Metric(self.width, exemplar.weights, features)
        super().__init__(metric, valid.flatten().nonzero()[:, 0], dims, generator)

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
        return self._snap[self.number(corners.clamp(torch.zeros_like(self._shape), self._shape - 1))]

    def windows(self, numbers: Tensor) -> Tensor:
        """See `Source.windows`."""
        return windows_at(self.pixels, self.corners(numbers), self.width)

    def values(self, numbers: Tensor, inside: Sequence[Tensor]) -> Tensor:
        """See `Source.values`."""
        place = [c + i for c, i in zip(self.corners(numbers).unbind(-1), inside, strict=True)]
        return self.pixels[tuple(place)].movedim(-1, 0)

    def projections(self, basis: Tensor, mean: Tensor) -> tuple[Tensor, Tensor]:
        """See `Source.projections`."""
        components = self.metric.transposed(basis.T.contiguous())
        return self._correlated(components).T.contiguous(), self._lengths(mean)

    def _correlated(self, kernels: Tensor, squared: bool = False) -> Tensor:
        """Inner products (K, positions) of window-shaped kernels (K, *width, C) with every window of the canvas."""
        canvas = self.exemplar.canvas[None]
        convolve = CONVOLUTION[len(self.width)]
        return convolve(canvas.square() if squared else canvas, kernels.movedim(-1, 1).contiguous())[0].flatten(1)

    def _lengths(self, mean: Tensor) -> Tensor:
        """|E z - mean|^2 for the window at every position."""
        if self.metric.plain:
            kernel = self.metric.transposed(mean[None])
            square = self._correlated(self.metric.weight[None], squared=True)[0]
            return square - 2 * self._correlated(kernel)[0] + (mean**2).sum()
        lengths = mean.new_zeros(math.prod(self.positions))
        for numbers in self.numbers.split(max(chunk(mean.device) // mean.numel(), 1)):
            lengths[numbers] = (self.metric.embed(self.windows(numbers)) - mean).square().sum(1)
        return lengths
