"""Which of the windows that cover a pixel weighs most there."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from kwatra.base import even_ranges, shared, threads_shared
from kwatra.base.compiled import jitted
from kwatra.windows import Grid, Layout, Metric


class Heaviest(NamedTuple):
    """The number of one window for each pixel (*S), 0 where none covers it, and the pixel's place in it (n, *S)."""

    window: Tensor
    place: Tensor


def heaviest_covering(layout: Layout, metric: Metric, weights: Tensor, corners: Tensor | None = None) -> Heaviest:
    """Of the windows that cover each pixel the one that weighs most there, the first of equals.

    weights (N,) of windows are multiplied by the falloff, which is separable. corners (N, n): where the places in each
    window are counted from, None for 0, where it begins.
    """
    profiles = [_profile(metric.falloff, axis) for axis in range(len(layout.shape))]
    if corners is None:
        corners = torch.zeros(len(layout), len(layout.shape), dtype=torch.long, device=layout.device)
    if isinstance(layout, Grid) and weights.device.type == "cpu":
        return _of_grid(layout, profiles, weights, corners)
    most = torch.full(layout.shape, -1.0, dtype=torch.float32, device=layout.device)
    window = torch.zeros(layout.shape, dtype=torch.long, device=layout.device)
    places = [torch.zeros_like(window) for _ in layout.shape]
    for number, inside, there in layout.coverings():
        share = torch.ones((), dtype=torch.float32, device=layout.device)
        for profile, place in zip(profiles, inside, strict=True):
            share = share * profile[place]
        weight = weights[number] * share
        better = there & (weight > most)
        most, window = torch.where(better, weight, most), torch.where(better, number, window)
        places = [torch.where(better, new, old) for new, old in zip(inside, places, strict=True)]
    return Heaviest(window, torch.stack(places) + corners.T[:, window])


def _profile(falloff: Tensor, axis: int) -> Tensor:
    """The falloff along one axis, summed over the others: but for a factor all there is to it, as it is separable."""
    others = [dim for dim in range(falloff.ndim) if dim != axis]
    return falloff.sum(others)


def _of_grid(layout: Grid, profiles: list[Tensor], weights: Tensor, corners: Tensor) -> Heaviest:
    """The same of a grid, in one pass over its pixels; threads share its rows."""
    *leading, (index, inside, own) = _axes(layout, profiles)
    number, share = torch.zeros(1, 1, dtype=torch.long), torch.ones(1, 1, dtype=torch.float32)
    places = torch.zeros(0, 1, 1, dtype=torch.long)
    for count, (numbers, there, shares) in zip(layout.counts, leading, strict=False):  # of rows: all axes but the last
        size = len(number) * len(numbers), number.shape[1] * numbers.shape[1]
        number = (number[:, None, :, None] * count + numbers[:, None]).reshape(size)
        absent = (share[:, None, :, None] < 0) | (shares[:, None] < 0)
        share = torch.where(absent, -1.0, share[:, None, :, None] * shares[:, None]).reshape(size)
        each = [*places[:, :, None, :, None], there[:, None]]
        places = torch.stack([place.expand(absent.shape).reshape(size) for place in each])
    rows, columns = len(number), layout.shape[-1]
    most = torch.full((rows, columns), -1.0, dtype=torch.float32)
    window, found = (torch.zeros(*some, rows, columns, dtype=torch.long) for some in ((), (len(layout.shape),)))
    given = (number * layout.counts[-1], share, places, index, inside, own, weights, corners)
    arrays = [a.contiguous().numpy() for a in given]
    made = most.numpy(), window.numpy(), found.numpy()
    shared(lambda part: _loop()(*arrays, *made, *part), even_ranges(rows, threads_shared()))
    return Heaviest(window.view(layout.shape), found.view(-1, *layout.shape))


def _axes(layout: Grid, profiles: list[Tensor]) -> list[tuple[Tensor, Tensor, Tensor]]:
    """Per axis, for each pixel, the windows that cover it, its place in them and their share; -1 of none."""
    found = []
    for axis, profile in enumerate(profiles):
        index, inside, there = layout.covering(axis)
        found.append((index, inside, torch.where(there, profile[inside], -1.0)))
    return found


@cache
def _loop() -> Any:
    return jitted(_heaviest)


def _heaviest(
    first: Any, share: Any, places: Any, index: Any, inside: Any, own: Any, weights: Any, corners: Any, most: Any,
    window: Any, found: Any, low: int, high: int,
) -> None:  # fmt: skip
    """Rows low to high; first, share, places: of the windows over a row, and the next three: over a column.

    What is multiplied first decides the last bit, and with it which of two is taken.
    """
    for row in range(low, high):
        for column in range(window.shape[1]):
            heaviest, number, down, right = most[row, column], window[row, column], -1, -1
            for a in range(share.shape[1]):
                for b in range(own.shape[1]):
                    if share[row, a] < 0 or own[column, b] < 0:
                        continue
                    other = first[row, a] + index[column, b]
                    weight = weights[np.uint64(other)] * (share[row, a] * own[column, b])
                    if weight > heaviest:
                        heaviest, number, down, right = weight, other, a, b
            if down >= 0:
                most[row, column], window[row, column] = heaviest, number
                for axis in range(len(places)):
                    found[axis, row, column] = places[axis, row, down] + corners[number, axis]
                found[-1, row, column] = inside[column, right] + corners[number, -1]
