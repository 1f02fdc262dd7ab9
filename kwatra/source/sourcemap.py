"""Where each output pixel comes from: canvas coordinates of the exemplar, (n, *S) int64, one per output pixel.

Between resolutions it is these coordinates that are carried, not colors: a finer level then starts from exemplar
pixels, as sharp as the exemplar, instead of an interpolated image.
"""

from collections.abc import Sequence
from itertools import product

import torch
from torch import Tensor

from kwatra.source.canvas import SourceWindows
from kwatra.windows import Grid


def winners(grid: Grid, source: SourceWindows, matches: Tensor, weights: Tensor) -> Tensor:
    """For each pixel the source coordinates from the window that weighs most there (weights (N,) times falloff)."""
    covers = [_covering(grid, axis) for axis in range(len(grid.shape))]
    profiles = [_profile(source.metric.falloff, axis) for axis in range(len(grid.shape))]
    most = torch.full(grid.shape, -1.0, device=grid.device)
    window = torch.zeros(grid.shape, dtype=torch.long, device=grid.device)
    for choice in product(*(range(index.shape[1]) for index, _ in covers)):
        number = torch.zeros((), dtype=torch.long, device=grid.device)
        share = torch.ones((), device=grid.device)
        for axis, (k, (index, inside)) in enumerate(zip(choice, covers, strict=True)):
            number = number[..., None] * grid.counts[axis] + index[:, k]
            share = share[..., None] * profiles[axis][inside[:, k]]
        weight = weights[number] * share
        better = weight > most
        most, window = torch.where(better, weight, most), torch.where(better, number, window)
    return _inside(grid, window) + source.corners(matches[window.flatten()]).T.view(-1, *grid.shape)


def _profile(falloff: Tensor, axis: int) -> Tensor:
    """The falloff along one axis, through its center."""
    others = [dim for dim in range(falloff.ndim) if dim != axis]
    return falloff.sum(others)


def _covering(grid: Grid, axis: int) -> tuple[Tensor, Tensor]:
    """For each pixel of an axis the windows covering it, (size, m), and the pixel's place in each, (size, m)."""
    size, width, position = grid.shape[axis], grid.width[axis], grid.positions[axis]
    inside = torch.arange(size, device=grid.device)[:, None] - position
    inside = inside % size if grid.wrap else inside
    covered = (inside >= 0) & (inside < width)
    most = int(covered.sum(1).max())
    order = covered.to(torch.int8).argsort(dim=1, descending=True, stable=True)[:, :most]
    # pixels covered by fewer windows name their first one again
    order = torch.where(covered.gather(1, order), order, order[:, :1])
    return order, inside.gather(1, order)


def _inside(grid: Grid, window: Tensor) -> Tensor:
    """Place (n, *S) of each pixel inside the window chosen for it."""
    axes = [torch.arange(s, device=grid.device) for s in grid.shape]
    pixel = torch.stack(torch.meshgrid(*axes, indexing="ij"))
    place = pixel - grid.corners[window.flatten()].T.view(-1, *grid.shape)
    if grid.wrap:
        place = place % torch.tensor(grid.shape, device=grid.device).view(-1, *[1] * len(grid.shape))
    return place


def at_windows(grid: Grid, source: SourceWindows, where: Tensor) -> Tensor:
    """The usable source windows (N,) that put the map's coordinates at each window's center."""
    center = grid.corners + torch.tensor([w // 2 for w in grid.width], device=grid.device)
    center = center % torch.tensor(grid.shape, device=grid.device)
    there = where[(slice(None), *center.T)].T
    return source.snapped(there - torch.tensor([w // 2 for w in grid.width], device=grid.device))


def finer(where: Tensor, factor: Sequence[int], shape: Sequence[int]) -> Tensor:
    """The map at `factor` times the resolution: blocks of pixels come from blocks of source pixels."""
    for axis, (f, size) in enumerate(zip(factor, shape, strict=True)):
        pixel = torch.arange(size, device=where.device)
        where = where.index_select(axis + 1, (pixel // f).clamp(max=where.shape[axis + 1] - 1))
        phase = (pixel % f).view(-1, *[1] * (len(shape) - 1 - axis))
        where = torch.cat([w * f + phase if a == axis else w for a, w in enumerate(where.split(1))])
    return where


def coarser(where: Tensor, factor: Sequence[int], shape: Sequence[int]) -> Tensor:
    """The map at 1 / `factor` of the resolution, from the middle of each block of pixels."""
    for axis, (f, size) in enumerate(zip(factor, shape, strict=True)):
        pixel = (torch.arange(size, device=where.device) * f + f // 2).clamp(max=where.shape[axis + 1] - 1)
        where = where.index_select(axis + 1, pixel)
    scale = torch.tensor(list(factor), device=where.device).view(-1, *[1] * len(shape))
    return where // scale


def carried(where: Tensor, old: Sequence[int], new: Sequence[int], shape: Sequence[int]) -> Tensor:
    """The map from a resolution of factors `old` at one of factors `new`, where the output is `shape`."""
    if any(o > n for o, n in zip(old, new, strict=True)):
        return finer(where, [o // n for o, n in zip(old, new, strict=True)], shape)
    return coarser(where, [n // o for o, n in zip(old, new, strict=True)], shape)


def look_up(pixels: Tensor, where: Tensor) -> Tensor:
    """The values (C, *S) that an image (C, *canvas) has at the map's coordinates."""
    return pixels[(slice(None), *where)]
