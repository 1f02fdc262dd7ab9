"""Votes: what the matched windows that cover a pixel make of it.

A vote returns where each pixel is pulled, and by what mass: the blend adds what terms want and solves for the image.
The mean is the minimum of the energy for given matches (thesis equation 19); the others keep one window's value
where windows differ, which does not blur. A vote of one's own is any function of a `Ballot`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from torch import Tensor

from kwatra.base import InputError, over_channels, power
from kwatra.source import Bag, Source, chunk, heaviest_covering
from kwatra.steps.inbag import modes_in_bag
from kwatra.steps.inplace import TINY, fits, means_in_place
from kwatra.windows import FreeWindows, Layout, Metric

DECIDING = 4
"""To this power weights count where the best windows decide: with 3 waterfalls are a little softer, with 6 they are not
sharper. A power of 6 of the weights of perfect matches would leave the range of floats."""


@dataclass(frozen=True, eq=False)
class Ballot:
    """Windows of a layout, the source windows they are matched with (N,), and their weights (N,) >= 0."""

    layout: Layout
    source: Source
    matches: Tensor
    weights: Tensor


class Pull(NamedTuple):
    """The value (C, *S) that each pixel is pulled to, and by what mass (1, *S), the sum of the weights.

    Where no window covers a pixel the mass is 0, and its value does not matter.
    """

    value: Tensor
    mass: Tensor


Vote = Callable[[Ballot], Pull]


def mean(ballot: Ballot) -> Pull:
    """Every window pulls by its weight and falloff. Memory: windows are summed in bands of bounded size."""
    if fits(ballot.source):
        return Pull(*means_in_place(ballot.layout, ballot.source, ballot.matches, ballot.weights))
    layout, metric = ballot.layout, ballot.source.metric
    whole = metric.falloff.expand_as(metric.weight).contiguous()  # in one stretch, products take a sixth of the time
    total = torch.zeros(whole.shape[-1], *layout.shape, dtype=torch.float32, device=layout.device)
    for part, band in bands(layout, metric):
        weight = ballot.weights[part].view(-1, *[1] * whole.ndim)
        total = band.scatter((weight * whole).mul_(ballot.source.windows(ballot.matches[part])), total)
    mass = _mass(ballot)
    return Pull(total.div_(mass.clamp(min=TINY)), mass)


def winner(ballot: Ballot) -> Pull:
    """The window that weighs most pulls alone, with the mass of all."""
    return Pull(_winners(ballot), _mass(ballot))


@dataclass(frozen=True)
class Mode:
    """The most frequent value pulls, with the mass of all: mean shift per pixel (Ruiters et al. 2010, section 4.4).

    bandwidth: standard deviation of the Gaussian kernel, in colors (root of the mean square over weighted channels);
    windows that differ by much more do not count. rounds: of the shift. It starts at the mean, and the kernel is at
    first four times as wide, then twice: so the mode is that of most weight (annealed mean shift; Shen, Brooks and van
    den Hengel, Fast global kernel density mode seeking, 2007). Begun at the winner, which changes from one pixel to
    the next, edges between stones came out in steps and specks.
    """

    bandwidth: float = 0.1
    rounds: int = 6

    def __post_init__(self) -> None:
        if not (0 < self.bandwidth < float("inf")) or self.rounds < 1:
            raise InputError(
                f"{self} has no bandwidth above 0 or no round; give a finite bandwidth and at least 1 round"
            )

    def __call__(self, ballot: Ballot) -> Pull:
        """The vote. Memory: a few images; the windows are gone through once in every round."""
        layout, source = ballot.layout, ballot.source
        widths = [self.bandwidth * max(4 / 2**number, 1) for number in range(self.rounds)]
        narrow = [0.0, *(1 / (2 * width**2) for width in widths)]  # first the mean
        if isinstance(layout, FreeWindows) and isinstance(source, Bag) and layout.device.type == "cpu":
            return Pull(*modes_in_bag(layout, source, ballot.matches, ballot.weights, narrow))
        mass = _mass(ballot)
        mode = torch.zeros(source.metric.weight.shape[-1], *layout.shape, dtype=torch.float32, device=layout.device)
        share = source.metric.share.view(-1, *[1] * len(layout.shape))
        falloff = source.metric.falloff[..., 0]
        for exponent in narrow:
            total, count = torch.zeros_like(mode), torch.zeros_like(mass)
            for number, inside, there in layout.coverings():
                window, *places = torch.broadcast_tensors(number, *inside)
                value = source.values(ballot.matches[window], places)
                apart = over_channels((value - mode).square() * share)
                weight = ballot.weights[window] * falloff[tuple(places)] * there
                weight = weight * torch.exp(-exponent * apart)
                total, count = total + weight * value, count + weight
            mode = torch.where(count > 0, total / count.clamp(min=TINY), mode)
        return Pull(mode, mass)


@dataclass(frozen=True)
class Decisive:
    """The windows that weigh most pull where others say about the same; where they differ by more, the mean does.

    A mean blurs, and one window alone is sharp, but between two of them is an edge, in a video a jump. So the pull is

        m + (s - m) t^2 / (t^2 + |s - m|^2),

    with m the mean, s the mean in which weights count to the power of DECIDING, t the tolerance and |.|^2 the mean
    square over weighted channels. tolerance: >= 0 and finite, in colors; an edge as large is hardly seen.
    """

    tolerance: float

    def __post_init__(self) -> None:
        if not (0 <= self.tolerance < float("inf")):
            raise InputError(f"the tolerance of {self} is not finite or below 0; it is a difference of colors")

    def __call__(self, ballot: Ballot) -> Pull:
        """The vote. Memory: a few images more than the mean."""
        middle, mass = mean(ballot)
        sharp, _ = mean(replace(ballot, weights=power(ballot.weights, DECIDING)))
        apart = sharp - middle
        share = ballot.source.metric.share.view(-1, *[1] * len(ballot.layout.shape))
        squared = over_channels(apart.square() * share)
        heeded = self.tolerance**2 / (self.tolerance**2 + squared).clamp(min=TINY)
        return Pull(middle + apart * heeded, mass)


def bands(layout: Layout, metric: Metric) -> list[tuple[slice, Layout]]:
    """The layout in bands that hold at most about `chunk` values each, with the slice of window numbers of each."""
    result, first = [], 0
    for band in layout.bands(max(chunk(layout.device) // metric.weight.numel(), 1)):
        result.append((slice(first, first + len(band)), band))
        first += len(band)
    return result


def _mass(ballot: Ballot) -> Tensor:
    layout, metric = ballot.layout, ballot.source.metric
    mass = torch.zeros(1, *layout.shape, dtype=torch.float32, device=layout.device)
    for part, band in bands(layout, metric):
        mass = band.scatter(ballot.weights[part].view(-1, *[1] * metric.falloff.ndim) * metric.falloff, mass)
    return mass


def _winners(ballot: Ballot) -> Tensor:
    """The value (C, *S) that the window of most weight has at each pixel."""
    heaviest = heaviest_covering(ballot.layout, ballot.source.metric, ballot.weights)
    return ballot.source.values(ballot.matches[heaviest.window], list(heaviest.place))
