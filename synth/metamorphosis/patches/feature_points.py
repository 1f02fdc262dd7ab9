"""Which feature pixels stand for a patch: few, evenly spread, and the same ones in patches that overlap.

The pixels of the whole map are put in an order once: first some that are far apart, then such as lie between them, and
so on down to neighbors (Poisson-disc sampling at falling radii; McCool and Fiume, Hierarchical Poisson disk sampling
distributions, 1992). A patch takes its first ones.
"""

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kwatra.base import InputError
from kwatra.base.compiled import jitted
from kwatra.windows.grid import windows_at

_FARTHEST, _RATIO = 32.0, 2**-0.25
"""Px between the points that are taken first, and by how much nearer to each other the next may lie. Not tuned: points
of any number are spread."""
_PIXELS = 1 << 22
"""Pixels of patches that are looked at at once."""


class Points(NamedTuple):
    """Sets of points, one per patch: places (N, n, 2), x first, in px from the center of the patch's first pixel.

    there (N, n): the others are padding.
    """

    places: Tensor
    there: Tensor


def feature_points(features: Tensor, corners: Tensor, width: int, most: int) -> Points:
    """At most `most` feature pixels of each patch, evenly spread.

    features (H, W): boolean, True at feature pixels. corners (N, 2): row and column of the first pixel of each patch,
    `width` pixels wide and high, all inside the map. Deterministic. Memory: 40 MB and what is returned.

    Raises InputError for a map that is not boolean or too small for a patch.
    """
    if features.dtype != torch.bool or features.ndim != 2 or min(features.shape) < width:
        raise InputError(
            f"a feature map has shape {tuple(features.shape)} and type {features.dtype}; give booleans (H, W) of at "
            f"least {width}x{width}, True at features"
        )
    ranks = _ranked(features)[..., None].contiguous()
    count, parts = min(most, width * width), []
    for some in corners.split(max(_PIXELS // width**2, 1)):
        inside = windows_at(ranks, some, (width, width)).flatten(1)
        rank, pixel = inside.topk(count, largest=False)
        there = rank < features.numel()
        places = torch.stack([pixel % width, pixel // width], 2).float() * there[..., None]
        parts.append(Points(places, there))
    return Points(*(torch.cat(part) for part in zip(*parts, strict=True)))


def _ranked(features: Tensor) -> Tensor:
    """The place of each feature pixel (H, W) in the order, H * W elsewhere."""
    rows, columns = np.nonzero(features.numpy())
    # a golden-ratio sequence in two dimensions: pixels that follow each other are far apart
    scattered = np.argsort((0.7548776662466927 * columns + 0.5698402909980532 * rows) % 1.0, kind="stable")
    ranks = np.full(features.shape, features.numel(), np.int64)
    _rank(rows[scattered], columns[scattered], ranks)
    return torch.from_numpy(ranks)


def _in_turn(rows: NDArray[np.int64], columns: NDArray[np.int64], ranks: NDArray[np.int64]) -> None:
    """Write the ranks of pixels: at each radius, in the order given, those that are no nearer to an earlier one."""
    none, count, radius = ranks.size, 0, _FARTHEST
    order = np.empty(len(rows), np.int64)
    covered = np.zeros(ranks.shape, np.bool_)
    while count < len(rows):
        covered[:] = False
        for taken in order[:count]:
            _cover(covered, rows[taken], columns[taken], radius)
        for pixel in range(len(rows)):
            y, x = rows[pixel], columns[pixel]
            if ranks[y, x] == none and (not covered[y, x] or radius <= 1):
                ranks[y, x], order[count] = count, pixel
                count += 1
                _cover(covered, y, x, radius)
        radius *= _RATIO


def _disc(covered: NDArray[np.bool_], row: int, column: int, radius: float) -> None:
    """Mark what lies nearer than the radius."""
    reach = int(radius)
    for y in range(max(row - reach, 0), min(row + reach + 1, covered.shape[0])):
        for x in range(max(column - reach, 0), min(column + reach + 1, covered.shape[1])):
            if (y - row) ** 2 + (x - column) ** 2 < radius * radius:
                covered[y, x] = True


_cover = jitted(_disc)
_rank = jitted(_in_turn)
