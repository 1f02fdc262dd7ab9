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
    return heaviest_covering(layout, source.metric, weights, source.corners(matches)).place


def at_windows(layout: Layout, source: Placed, where: Tensor) -> Tensor:
    """The usable source windows (N,) that put the map's coordinates at each window's center.

    Near a video's joints in time the copy at the center often begins or ends with its clip, and a window of it would
    lie beyond. Snapped into the clip it would show a frame again, or leave one out, and matches spread from there: of
    the joints in smoke half as large again a quarter were places where time stood still, and motion faltered. Such a
    window takes the copy that is seen in another of its frames, the nearest to its center of which it fits: three seeds
    score .074 in place of .078, fish .063 in place of .066.
    """
    middle = [w // 2 for w in layout.width]
    there = _pointed_to(layout.corners, middle, layout, where)
    number = source.snapped(there)
    if len(middle) < 3:
        return number
    beyond = (source.corners(number)[:, 0] != there[:, 0]).nonzero()[:, 0]
    for frame in sorted(range(layout.width[0]), key=lambda frame: abs(frame - middle[0]))[1:]:
        there = _pointed_to(layout.corners[beyond], [frame, *middle[1:]], layout, where)
        other = source.snapped(there)
        fits = source.corners(other)[:, 0] == there[:, 0]
        number[beyond[fits]] = other[fits]
        beyond = beyond[~fits]
    return number


def _pointed_to(corners: Tensor, inside: Sequence[int], layout: Layout, where: Tensor) -> Tensor:
    """The corners (N, n) of source windows that put the map's coordinates at a place inside of windows at others."""
    place = torch.tensor(inside, device=corners.device)
    at = (corners + place) % torch.tensor(layout.shape, device=corners.device)
    return where[(slice(None), *at.T)].T - place


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
    if tuple(old) == tuple(new):
        return where
    if any(o > n for o, n in zip(old, new, strict=True)):
        return finer(where, [o // n for o, n in zip(old, new, strict=True)], shape)
    return coarser(where, [n // o for o, n in zip(old, new, strict=True)], shape)


def look_up(pixels: Tensor, where: Tensor) -> Tensor:
    """The values (C, *S) that an image (C, *canvas) has at the map's coordinates."""
    place = where[0].clone()
    for axis, side in enumerate(pixels.shape[2:], 1):
        place.mul_(side).add_(where[axis])
    return pixels.flatten(1).gather(1, place.flatten().expand(len(pixels), -1)).view(len(pixels), *place.shape)
