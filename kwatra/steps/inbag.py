"""Votes of free windows from a bag, pixel by pixel: the same as elsewhere, with what covers a pixel held only once.

For colors on the CPU: what `Mode` needs passes over all pixels for, each with temporaries of an image's size.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base.compiled import Compiled
from kwatra.source import Bag
from kwatra.windows import FreeWindows


def modes_in_bag(
    layout: FreeWindows, bag: Bag, matches: Tensor, weights: Tensor, narrow: Sequence[float]
) -> tuple[Tensor, Tensor]:
    """See `kwatra.steps.votes.Mode`: the modes (C, *S), and the masses (1, *S).

    narrow: for each round what squared differences are multiplied by in the kernel's exponent; 0 gives the mean.
    Memory: what is returned, and two numbers per pixel and window that covers it.
    """
    window, place, count = layout.covers
    channels = bag.metric.weight.shape[-1]
    modes, mass = (
        torch.zeros(channels, *layout.shape, dtype=torch.float32),
        torch.zeros(1, *layout.shape, dtype=torch.float32),
    )
    _modes(
        math.prod(layout.shape), bag.held.flatten(1, -2), matches.contiguous(), weights.contiguous(),
        bag.metric.falloff.flatten(), bag.metric.share, window, place, count, np.array(narrow),
        modes.view(channels, -1), mass.view(-1),
    )  # fmt: skip
    return modes, mass


@Compiled
def _modes(
    bag: Any, matches: Any, weights: Any, falloff: Any, share: Any, windows: Any, places: Any, count: Any,
    narrow: Any, modes: Any, mass: Any, low: int, high: int,
) -> None:  # fmt: skip
    """The pixels from low to high: a mean shift of as many rounds as kernels are given."""
    most, channels = len(windows), len(modes)
    values, pull = np.empty((most, channels), np.float32), np.empty(most, np.float32)
    mode, near = np.empty(channels), np.empty(channels)
    for pixel in range(low, high):
        for k in range(count[pixel]):
            window, place = windows[k, pixel], places[k, pixel]
            pull[k] = weights[window] * falloff[place]
            mass[pixel] += pull[k]
            for c in range(channels):
                values[k, c] = bag[matches[window], place, c]
        mode[:] = 0.0
        for exponent in narrow:
            seen = 0.0
            near[:] = 0.0
            for k in range(count[pixel]):
                apart = 0.0
                for c in range(channels):
                    apart += share[c] * (values[k, c] - mode[c]) ** 2
                weight = pull[k] * np.exp(-exponent * apart)
                seen += weight
                for c in range(channels):
                    near[c] += weight * values[k, c]
            if seen > 0:
                for c in range(channels):
                    mode[c] = near[c] / seen
        for c in range(channels):
            modes[c, pixel] = mode[c]
