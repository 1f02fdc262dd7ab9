"""How like itself a picture is after a move: autocorrelation over all channels, of what is there alone.

Every lag is normalized by what overlaps at it (Padfield 2012, "Masked object registration in the Fourier domain"), so
that neither a hole's content nor a picture's border counts. Sums over channels do not depend on the axes of the color
space: a principal component counts with its variance, whichever channels it is mixed from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import torch
import torch.nn.functional as F
from scipy import fft
from torch import Tensor

from kwatra.base import over_channels, running, total
from kwatra.base.spans import span_sums
from kwatra.elements.kept import kept_up_to
from kwatra.exemplar import Exemplar

EDGE_SIGMA = 1.0
"""Edges are sought in a picture blurred by this many pixels, as is usual."""

LEAST_OVERLAP = 0.1
"""Lags are looked at at which at least this share of the pictures overlaps: one and a half periods do."""

SMALL = 1 << 17
"""Up to so many pixels of an exemplar what is found here is kept, 14 MB at most: then its size is asked for, and its
lattice. Of six megapixels it would be .6 GB, and where textures are made of these the size alone is asked for."""


@dataclass(frozen=True)
class Correlation:
    """Autocorrelation by lag; both (2 R + 1, 2 Q + 1), lags from -R to R down and from -Q to Q right, 0 in the middle.

    value: -1 to 1, the likeness of what overlaps at a lag, 0 where nothing does. overlap: how many pixels overlap.
    """

    value: Tensor
    overlap: Tensor

    @property
    def reach(self) -> tuple[int, int]:
        """The largest lag down and right."""
        return self.value.shape[0] // 2, self.value.shape[1] // 2

    def within(self, reach: int) -> "Correlation":
        """The lags up to `reach` down and right."""
        middle = tuple(slice(far - reach, far + reach + 1) for far in self.reach)
        return Correlation(self.value[middle], self.overlap[middle])

    def trusted(self) -> "Correlation":
        """The same, 0 without overlap where too little overlaps."""
        known = self.overlap >= LEAST_OVERLAP * self.overlap.max()
        return Correlation(torch.where(known, self.value, 0.0), torch.where(known, self.overlap, 0.0))

    def mean_by(self, distance: Tensor, count: int) -> tuple[Tensor, Tensor]:
        """The mean value (n,) by a distance of lags (2 R + 1, 2 Q + 1), and how much overlaps there; n <= `count`.

        Lags count by what overlaps at them, and between two whole distances for both.
        """
        distance, overlap = distance.flatten(), self.overlap.flatten()
        low = distance.floor().long()
        share, sums = distance - low, []
        for values in (self.value.flatten() * overlap, overlap):
            bins = torch.zeros(int(low.max()) + 2, dtype=values.dtype)
            bins.index_add_(0, low, values * (1 - share)).index_add_(0, low + 1, values * share)
            sums.append(bins[:count])
        return sums[0] / sums[1].clamp(min=1e-9), sums[1]

    @cached_property
    def highest_near(self) -> Tensor:
        """The highest value (2 R + 1, 2 Q + 1) within a pixel of each lag: a repetition need not be whole pixels."""
        return running(torch.maximum, F.pad(self.value, (1, 1, 1, 1), value=-1.0), (3, 3))


@kept_up_to(SMALL)
def of_colors(exemplar: Exemplar) -> Correlation:
    """The autocorrelation of an exemplar's colors, for all lags at which enough of it overlaps."""
    return autocorrelation(pictures(exemplar))


@kept_up_to(SMALL)
def of_edges(exemplar: Exemplar) -> Correlation:
    """The same of the strength of its edges."""
    return autocorrelation([(edges(*image), image[1]) for image in pictures(exemplar)])


def pictures(exemplar: Exemplar) -> list[tuple[Tensor, Tensor]]:
    """The exemplar's images as they were given, (C, ..., H, W) float64, and where they may be looked at, (..., H, W).

    What may not be looked at is 0.
    """
    return [
        (torch.where(inside, exemplar.canvas[(slice(None), *box)], 0.0).double(), inside.double())
        for box, inside in exemplar.places()
    ]


def edges(picture: Tensor, present: Tensor) -> Tensor:
    """The strength of edges (1, ..., H, W) in all channels of a picture: the root of the squared differences' sum."""
    smooth = _blurred(picture) / _blurred(present[None]).clamp(min=1e-6)
    rim = F.pad(smooth.flatten(0, -3), (1, 1, 1, 1), mode="replicate")
    down, right = rim[:, 2:, 1:-1] - rim[:, :-2, 1:-1], rim[:, 1:-1, 2:] - rim[:, 1:-1, :-2]
    return over_channels((down.square() + right.square()).view(smooth.shape))[None].sqrt() * present


def _blurred(stack: Tensor) -> Tensor:
    taps = torch.arange(-3, 4, dtype=stack.dtype)
    kernel = torch.exp(-0.5 * (taps / EDGE_SIGMA).square())
    flat = stack.reshape(-1, 1, *stack.shape[-2:])
    flat = F.conv2d(F.conv2d(flat, kernel.view(1, 1, -1, 1), padding=(3, 0)), kernel.view(1, 1, 1, -1), padding=(0, 3))
    return flat.view(stack.shape)


def autocorrelation(images: list[tuple[Tensor, Tensor]]) -> Correlation:
    """The autocorrelation of pictures (C, ..., H, W), each with its `present` (..., H, W).

    It is that of all lags at which enough of the largest overlaps. Pictures, and the frames of a video, are pooled:
    each counts by how much of it overlaps.
    """
    height, width = (max(present.shape[axis] for _, present in images) for axis in (-2, -1))
    reach = int((1 - LEAST_OVERLAP) * height), int((1 - LEAST_OVERLAP) * width)
    sums = [_products(picture, present, reach) for picture, present in images]
    together, first, second, overlap = (sum(parts[1:], parts[0]) for parts in zip(*sums, strict=True))
    scale = (first.clamp(min=0) * second.clamp(min=0)).sqrt()
    known = (overlap > 0.5) & (scale > 1e-9 * float(first.max()))
    value = torch.where(known, together / scale.clamp(min=1e-30), 0.0)
    return Correlation(value.clamp(-1, 1), overlap.round().clamp(min=0))


def _products(picture: Tensor, present: Tensor, reach: tuple[int, int]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Covariance and both variances of what overlaps at each lag, times the overlap, and the overlap.

    Channels and frames are looked at one by one: memory is that of a few arrays of all lags.
    """
    inside = total(present).clamp(min=1)
    centered = torch.stack([channel - total(channel) / inside for channel in picture]) * present
    size = [fft.next_fast_len(max(s + r, 2 * r + 1), real=True) for s, r in zip(picture.shape[-2:], reach, strict=True)]
    lags = 2 * reach[0] + 1, 2 * reach[1] + 1
    together, first, overlap = (torch.zeros(lags, dtype=picture.dtype) for _ in range(3))
    power = torch.zeros(size[0], size[1] // 2 + 1, dtype=picture.dtype)
    frames = centered.reshape(len(centered), -1, *present.shape[-2:]).unbind(1)
    for frame, there in zip(frames, present.reshape(-1, *present.shape[-2:]), strict=True):
        over = _over(there, reach, size)
        pixels = over(there).clamp(min=0)
        first += over(over_channels(frame.square()))
        overlap += pixels
        pixels.clamp_(min=0.5)
        for channel in frame:
            here = over(channel)
            # what lies a lag further is what lay here, seen from there
            together -= here.flip(-2, -1).mul_(here).div_(pixels)
            first -= here.square_().div_(pixels)
            power += torch.view_as_real(torch.fft.rfft2(channel, s=size)).square_().sum(-1)
    together += _at_lags(torch.fft.irfft2(power, s=size), reach)
    return together, first, first.flip(-2, -1), overlap


def _over(present: Tensor, reach: tuple[int, int], size: list[int]) -> Callable[[Tensor], Tensor]:
    """What sums a picture (H, W) at each lag over those of its pixels that lie on others, of which a lag further are.

    That is a rectangle at each lag where all are present, else a correlation with what is.
    """
    if bool((present == 1).all()):
        return partial(_in_rectangles, reach=reach)
    there = torch.fft.rfft2(present, s=size)

    def correlated(values: Tensor) -> Tensor:
        return _at_lags(torch.fft.irfft2(torch.fft.rfft2(values, s=size).conj() * there, s=size), reach)

    return correlated


def _in_rectangles(values: Tensor, reach: tuple[int, int]) -> Tensor:
    """The sum of values (H, W) over the rectangle in which they lie on themselves, moved by each lag."""
    lags = [(np.arange(-r, r + 1), size) for r, size in zip(reach, values.shape, strict=True)]
    sides = [(np.clip(-lag, 0, size), np.clip(size - lag, 0, size)) for lag, size in lags]
    return torch.from_numpy(span_sums(values.numpy(), sides))


def _at_lags(periodic: Tensor, reach: tuple[int, int]) -> Tensor:
    """The lags up to `reach` of a correlation (H, W) in which those below 0 come last."""
    down, right = (torch.arange(-r, r + 1) for r in reach)
    return periodic[down][:, right]
