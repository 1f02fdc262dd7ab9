"""Coherent candidates: what a window's neighbors are matched with, shifted (Ashikhmin 2001).

They go on where a neighbor's copy ends. On a grid they are found in one pass: looked up by tensors, neighbor by
neighbor, they took as long as comparing them, and threads waited for each other at each step.
"""

from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base.compiled import jitted
from kwatra.source import Placed, Source
from kwatra.steps.inplace import fits
from kwatra.windows import Grid, Layout


def coherent(layout: Layout, source: Source, matches: Tensor, part: slice) -> Tensor:
    """The match of each window of a part and its neighbors' matches, shifted: (n, 1 + 2 axes); or the match alone.

    matches (N,): those of all windows. Only windows that have places have neighbors.
    """
    if fits(source) and isinstance(layout, Grid):
        first, stop, _ = part.indices(len(layout))
        candidates = torch.empty(stop - first, 1 + 2 * len(layout.shape), dtype=torch.long)
        positions = np.zeros((len(layout.shape), max(layout.counts)), np.int64)
        for line, at in zip(positions, layout.positions, strict=True):
            line[: len(at)] = at.numpy()
        counts, shape, wraps, room = map(np.array, (layout.counts, layout.shape, layout.wraps, source.positions))
        arrays = matches.numpy(), source.snap.numpy(), candidates.numpy()
        _of_grid(first, counts, shape, wraps, room, positions, *arrays)
        return candidates
    columns = [matches[part]]
    if isinstance(source, Placed):
        for neighbor, shift in layout.neighbor_shifts(part):
            columns.append(source.snapped(source.corners(matches[neighbor]) + shift))
    return torch.stack(columns, 1)


@jitted
def _of_grid(
    first: int, counts: Any, shape: Any, wraps: Any, room: Any, positions: Any, matches: Any, snap: Any, candidates: Any
) -> None:
    """The same of the windows of a grid from the first on, in one pass over them.

    counts, shape, wraps (axes,): of the grid; room (axes,): in how many places along an axis the source's windows are,
    numbered row by row; positions (axes, m): where the grid's are; snap: which of the source's counts for each.
    """
    for row in range(len(candidates)):
        window, column = first + row, 1
        candidates[row, 0] = matches[window]
        stride, step = len(matches), len(snap)
        for axis in range(len(counts)):
            count, size = counts[axis], shape[axis]
            stride //= count
            step //= room[axis]
            here = window // stride % count
            for sign in (1, -1):
                there = (here - sign) % count if wraps[axis] else min(max(here - sign, 0), count - 1)
                away = positions[axis, here] - positions[axis, there]
                if wraps[axis]:
                    away = (away + size // 2) % size - size // 2
                match = matches[window + (there - here) * stride]
                along = match // step % room[axis]
                moved = min(max(along + away, 0), room[axis] - 1)
                candidates[row, column] = snap[match + (moved - along) * step]
                column += 1
