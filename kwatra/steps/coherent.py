"""Coherent candidates: what a window's neighbors are matched with, shifted (Ashikhmin 2001).

They go on where a neighbor's copy ends. On a grid they are found in one pass: looked up by tensors, neighbor by
neighbor, they took as long as comparing them, and threads waited for each other at each step.
"""

from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from kwatra.base.compiled import Compiled, inlined, jitted
from kwatra.source import Placed, Source, SourceWindows
from kwatra.steps.inplace import FARTHEST, Lines, by_rows, difference, first_of, fits, start_of
from kwatra.windows import Grid, Layout


def coherent(layout: Layout, source: Source, matches: Tensor, part: slice) -> Tensor:
    """The match of each window of a part and its neighbors' matches, shifted: (n, 1 + 2 axes); or the match alone.

    matches (N,): those of all windows. Only windows that have places have neighbors.
    """
    if fits(source) and isinstance(layout, Grid):
        first, stop, _ = part.indices(len(layout))
        candidates = torch.empty(stop - first, 1 + 2 * len(layout.shape), dtype=torch.long)
        _find_all(first, *_neighbors_of(layout, source, matches), candidates.numpy())
        return candidates
    columns = [matches[part]]
    if isinstance(source, Placed):
        for neighbor, shift in layout.neighbor_shifts(part):
            columns.append(source.snapped(source.corners(matches[neighbor]) + shift))
    return torch.stack(columns, 1)


def nearest_coherent(
    pixels: Tensor, layout: Grid, source: SourceWindows, matches: Tensor, settled: float
) -> tuple[Tensor, Tensor]:
    """Of its coherent candidates the nearest to each window, the first of equals: numbers (N,), squared distances (N,).

    As `nearest_in_place` of all that `coherent` finds; but after one no further than `settled` none is even looked up,
    and inside of a copy the first is such a one.
    """
    number, squared = torch.empty_like(matches), torch.empty(len(matches), dtype=torch.float32)
    here, there = (Lines.of(image, source.width) for image in (pixels, source.pixels))
    near, weight = _neighbors_of(layout, source, matches), by_rows(source.metric.weight)
    _find_nearest(len(matches), *near, layout.corners.contiguous(), *here, *there, weight, settled, number, squared)
    return number, squared


class _Neighbors(NamedTuple):
    """The windows of a grid, what they are matched with, and where that is among a source's windows.

    counts (axes,): how many windows there are along each axis; shape, wraps (axes,): the grid's; positions (axes, m):
    where its windows begin. matches (N,). room (axes,): as counts of the source's windows; snap: which of these counts
    for each.
    """

    counts: Any
    shape: Any
    wraps: Any
    positions: Any
    matches: Any
    room: Any
    snap: Any


def _neighbors_of(layout: Grid, source: SourceWindows, matches: Tensor) -> _Neighbors:
    positions = np.zeros((len(layout.shape), max(layout.counts)), np.int64)
    for line, at in zip(positions, layout.positions, strict=True):
        line[: len(at)] = at.numpy()
    counts, shape, wraps, room = map(np.array, (layout.counts, layout.shape, layout.wraps, source.positions))
    return _Neighbors(counts, shape, wraps, positions, matches.numpy(), room, source.snap.numpy())


@inlined
def _shifted(
    window: int, here: int, axis: int, sign: int, stride: int, step: int, shape: Any, wraps: Any, positions: Any,
    counts: Any, matches: Any, room: Any, snap: Any,
) -> Any:  # fmt: skip
    """What the neighbor before a window along an axis, or behind it, is matched with, shifted.

    here: which of the windows along the axis it is; stride, step: from one of them, and of the source's, to the next.
    """
    count, size = counts[axis], shape[axis]
    there = (here - sign) % count if wraps[axis] else min(max(here - sign, 0), count - 1)
    away = positions[axis, here] - positions[axis, there]
    if wraps[axis]:
        away = (away + size // 2) % size - size // 2
    match = matches[window + (there - here) * stride]
    along = match // step % room[axis]
    moved = min(max(along + away, 0), room[axis] - 1)
    return snap[match + (moved - along) * step]


@jitted
def _find_all(
    first: int, counts: Any, shape: Any, wraps: Any, positions: Any, matches: Any, room: Any, snap: Any, candidates: Any
) -> None:
    """Set all candidates (n, columns) of the windows from the first on."""
    for row in range(len(candidates)):
        window, column = first + row, 1
        candidates[row, 0] = matches[window]
        stride, step = len(matches), len(snap)
        for axis in range(len(counts)):
            stride //= counts[axis]
            step //= room[axis]
            here = window // stride % counts[axis]
            for sign in (1, -1):
                candidates[row, column] = _shifted(
                    window, here, axis, sign, stride, step, shape, wraps, positions, counts, matches, room, snap
                )
                column += 1


@Compiled
def _find_nearest(
    counts: Any, shape: Any, wraps: Any, positions: Any, matches: Any, room: Any, snap: Any,
    corners: Any, ours: Any, rows: Any, along: Any, theirs: Any, their_rows: Any, their_steps: Any, weight: Any,
    settled: float, number: Any, squared: Any, low: int, high: int,
) -> None:  # fmt: skip
    for window in range(low, high):
        at, best = first_of(corners, window, along), matches[window]
        start = start_of(best, room, their_steps)
        least = difference(ours, at, rows, theirs, start, their_rows, weight, FARTHEST, np.float32(0))
        stride, step = len(matches), len(snap)
        for axis in range(len(counts)):
            if least <= settled:
                break
            stride //= counts[axis]
            step //= room[axis]
            here = window // stride % counts[axis]
            for sign in (1, -1):
                if least <= settled:
                    break
                other = _shifted(
                    window, here, axis, sign, stride, step, shape, wraps, positions, counts, matches, room, snap
                )
                if other != best:
                    start = start_of(other, room, their_steps)
                    distance = difference(ours, at, rows, theirs, start, their_rows, weight, least, np.float32(0))
                    if distance < least:
                        best, least = other, distance
        number[window], squared[window] = best, least
