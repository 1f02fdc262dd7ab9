"""Where each output pixel comes from: canvas coordinates of the exemplar, (n, *S) int64, one per output pixel.

Between resolutions it is these coordinates that are carried, not colors: a finer level then starts from exemplar
pixels, as sharp as the exemplar, instead of an interpolated image.
"""

from collections.abc import Sequence

import torch
from torch import Tensor

from kwatra.source.heaviest import heaviest_covering
from kwatra.source.protocol import Placed
from kwatra.windows import Layout


def winners(layout: Layout, source: Placed, matches: Tensor, weights: Tensor) -> Tensor:
    """For each pixel the source coordinates from the window that weighs most there (weights (N,) times falloff)."""
    heaviest = heaviest_covering(layout, source.metric, weights)
    corners = source.corners(matches)[heaviest.window.flatten()].T.view(-1, *layout.shape)
    return torch.stack(heaviest.inside).add_(corners)


def at_windows(layout: Layout, source: Placed, where: Tensor) -> Tensor:
    """The usable source windows (N,) that put the map's coordinates at each window's center."""
    center = layout.corners + torch.tensor([w // 2 for w in layout.width], device=layout.device)
    center = center % torch.tensor(layout.shape, device=layout.device)
    there = where[(slice(None), *center.T)].T
    return source.snapped(there - torch.tensor([w // 2 for w in layout.width], device=layout.device))


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
    place = where[0].clone()
    for axis, side in enumerate(pixels.shape[2:], 1):
        place.mul_(side).add_(where[axis])
    return pixels.flatten(1).index_select(1, place.flatten()).view(-1, *place.shape)
