"""Votes: what the matched windows that cover a pixel make of it.

A vote returns what pulls each pixel where, as a sum and a mass: the blend adds what terms want and solves for the
image. The mean is the minimum of the energy for given matches (thesis equation 19); the others keep one window's value
where windows differ, which does not blur. A vote of one's own is any function of a `Ballot`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.source import CHUNK, Source, heaviest_covering
from kwatra.steps.inplace import fits, sums_in_place
from kwatra.windows import Layout, Metric


@dataclass(frozen=True, eq=False)
class Ballot:
    """Windows of a layout, the source windows they are matched with (N,), and their weights (N,) >= 0."""

    layout: Layout
    source: Source
    matches: Tensor
    weights: Tensor


class Pull(NamedTuple):
    """The weighted sum (C, *S) of the values that a pixel is pulled to, and the sum (1, *S) of the weights."""

    total: Tensor
    mass: Tensor


Vote = Callable[[Ballot], Pull]


def mean(ballot: Ballot) -> Pull:
    """Every window pulls by its weight and falloff. Memory: windows are summed in place or in bands of bounded size."""
    if fits(ballot.source):
        return Pull(*sums_in_place(ballot.layout, ballot.source, ballot.matches, ballot.weights))
    layout, metric = ballot.layout, ballot.source.metric
    whole = metric.falloff.expand_as(metric.weight).contiguous()  # in one stretch, products take a sixth of the time
    total = torch.zeros(whole.shape[-1], *layout.shape, device=layout.device)
    for part, band in bands(layout, metric):
        weight = ballot.weights[part].view(-1, *[1] * whole.ndim)
        total = band.scatter((weight * whole).mul_(ballot.source.windows(ballot.matches[part])), total)
    return Pull(total, _mass(ballot))


def winner(ballot: Ballot) -> Pull:
    """The window that weighs most pulls alone, with the mass of all."""
    mass = _mass(ballot)
    return Pull(_winners(ballot) * mass, mass)


@dataclass(frozen=True)
class Mode:
    """The most frequent value pulls, with the mass of all: mean shift per pixel (Ruiters et al. 2010, section 4.4).

    bandwidth: standard deviation of the Gaussian kernel, in colors (root of the mean square over weighted channels);
    windows that differ by much more do not count. It starts at the winner. rounds: of the shift.
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
        mass, mode = _mass(ballot), _winners(ballot)
        share = ballot.source.metric.share.view(-1, *[1] * len(ballot.layout.shape))
        falloff = ballot.source.metric.falloff[..., 0]
        for _ in range(self.rounds):
            total, count = torch.zeros_like(mode), torch.zeros_like(mass)
            for number, inside, there in ballot.layout.coverings():
                window, *places = torch.broadcast_tensors(number, *inside)
                value = ballot.source.values(ballot.matches[window], places)
                apart = ((value - mode).square() * share).sum(0)
                weight = ballot.weights[window] * falloff[tuple(places)] * there
                weight = weight * torch.exp(-apart / (2 * self.bandwidth**2))
                total, count = total + weight * value, count + weight
            mode = torch.where(count > 0, total / count.clamp(min=1e-30), mode)
        return Pull(mode * mass, mass)


def bands(layout: Layout, metric: Metric) -> list[tuple[slice, Layout]]:
    """The layout in bands that hold at most about CHUNK values each, with the slice of window numbers of each."""
    result, first = [], 0
    for band in layout.bands(max(CHUNK // metric.weight.numel(), 1)):
        result.append((slice(first, first + len(band)), band))
        first += len(band)
    return result


def _mass(ballot: Ballot) -> Tensor:
    layout, metric = ballot.layout, ballot.source.metric
    mass = torch.zeros(1, *layout.shape, device=layout.device)
    for part, band in bands(layout, metric):
        mass = band.scatter(ballot.weights[part].view(-1, *[1] * metric.falloff.ndim) * metric.falloff, mass)
    return mass


def _winners(ballot: Ballot) -> Tensor:
    """The value (C, *S) that the window of most weight has at each pixel."""
    heaviest = heaviest_covering(ballot.layout, ballot.source.metric, ballot.weights)
    return ballot.source.values(ballot.matches[heaviest.window], heaviest.inside)
