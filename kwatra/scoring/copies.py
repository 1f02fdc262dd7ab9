"""Where an output comes from: its verbatim copies, and how evenly the exemplar is used.

A window of the output is a verbatim copy when its nearest exemplar window is no further than a
tolerance. Neighboring copies with one offset form a region, and a region's pixels are all that its
windows cover; where regions overlap the larger takes the pixel. An exemplar window that occurs
several times exactly (flat paper, drawn patterns) counts as copied from one of its places, so on
such exemplars the regions come out too small and the use too uneven.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import joined
from kwatra.scoring.nearest import PART, Nearest, Windows

BINS = 8
"""Bins to a side of an exemplar image for the entropy of use: it defines the figure."""


@dataclass(frozen=True)
class CopyMap:
    """What was copied from where.

    region (H, W) int64: 0 where nothing was copied, else the number of the pixel's region, larger
    numbers for larger regions. offset (2, H, W) int64, x first: pixel p was copied from p + offset
    (0 where nothing was). image (H, W) int64: number of the exemplar image it was copied from
    (-1 where nothing was). size: area-weighted mean area of the regions as a part of the exemplar's
    area, 0..1. use: entropy of the places that all windows, copied or merely like, are nearest to,
    0 (one place) to 1 (all alike).
    """

    region: Tensor
    offset: Tensor
    image: Tensor
    size: float
    use: float


@dataclass(frozen=True)
class _Sources:
    """Nearest source windows on a grid of output windows: rows (h,), columns (w,) in pixels.

    distance (h, w): rms. place (3, h, w): image, row and column in the exemplar.
    """

    rows: Tensor
    columns: Tensor
    distance: Tensor
    place: Tensor

    @property
    def offset(self) -> Tensor:
        """Image, and steps down and right to the source, (3, h, w)."""
        down = self.place[1] - self.rows[:, None]
        right = self.place[2] - self.columns
        return torch.stack((self.place[0], down, right))


def trace(output: Tensor, exemplar: list[Tensor], window: int, tolerance: float) -> CopyMap:
    """The copy map of an output (C, H, W); tolerance is the rms distance of a verbatim copy."""
    source_windows = Windows.of(exemplar, window)
    sources = _sources(Windows.of([output], window), Nearest(source_windows))
    region, first = _regions(sources, window, tolerance, output.shape[1:])
    offset = torch.cat((torch.tensor([[-1], [0], [0]]), sources.offset.flatten(1)[:, first]), 1)
    image, down, right = offset[:, region]
    areas = region.flatten().bincount()[1:].double()
    size = float(areas.square().sum()) / region.numel() / _area(exemplar)
    use = _use(sources.place.flatten(1), [grid[1:] for grid in source_windows.grids])
    return CopyMap(region, torch.stack((right, down)), image, size, use)


def pasted(where: Tensor, area: int) -> float:
    """The area-weighted mean area of a source map's (n, H, W) copies, as a part of the exemplar's area in pixels.

    A copy hangs together and has one offset.
    """
    axes = torch.meshgrid(*[torch.arange(side) for side in where.shape[1:]], indexing="ij")
    offset = where.cpu() - torch.stack(axes)
    sizes = np.bincount(_connected(offset, torch.ones(where.shape[1:], dtype=torch.bool))).astype(float)
    return float((sizes**2).sum() / sizes.sum() / area)


def nothing_copied(shape: Sequence[int]) -> CopyMap:
    """The copy map (H, W) of an output whose places of origin cannot be told apart."""
    nothing = torch.zeros(*shape, dtype=torch.long)
    return CopyMap(nothing, torch.stack((nothing, nothing)), nothing - 1, size=0.0, use=1.0)


def _area(exemplar: list[Tensor]) -> int:
    return sum(image.shape[1] * image.shape[2] for image in exemplar)


def _sources(windows: Windows, nearest: Nearest) -> _Sources:
    _, height, width = windows.grids[0]
    step = _step(height * width, windows.size)
    rows, columns = _every(step, height), _every(step, width)
    numbers = (rows[:, None] * width + columns).flatten()
    found = [nearest.search(windows.rows(part), candidates=2) for part in numbers.split(PART)]
    distance, source = (torch.cat(parts) for parts in zip(*found, strict=True))
    shape = len(rows), len(columns)
    place = nearest.windows.places(source)[[0, 2, 3]].reshape(3, *shape)
    return _Sources(rows, columns, distance.reshape(shape), place)


def _step(count: int, window: int) -> int:
    """Pixels between the windows looked up; a region's edge is known to step - 1 pixels."""
    if count <= PART // 4:
        return 1
    return 2 if count <= 4 * PART else window // 2


def _every(step: int, count: int) -> Tensor:
    """0, step, 2 step... and always the last, so that windows reach the border."""
    return torch.unique(torch.cat((torch.arange(0, count, step), torch.tensor([count - 1]))))


def _regions(sources: _Sources, window: int, tolerance: float, shape: Sequence[int]) -> tuple[Tensor, Tensor]:
    """Regions per pixel (H, W), numbered by size from 1, and one grid window of each region (n,)."""
    verbatim = sources.distance <= tolerance
    part = _connected(sources.offset, verbatim)
    first = np.unique(part, return_index=True)[1]
    count = np.bincount(part, weights=verbatim.flatten())
    order = np.argsort(count, kind="stable")[np.sum(count == 0) :]
    rank = np.zeros(len(count), dtype=int)
    rank[order] = np.arange(1, len(order) + 1)
    numbered = torch.from_numpy(rank[part]).reshape(verbatim.shape)
    return _cover(numbered, sources, window, shape), torch.from_numpy(first[order])


def _connected(offset: Tensor, verbatim: Tensor) -> np.ndarray:
    """Component (h * w,) of each grid window; neighbors connect when verbatim and of one offset."""
    links = []
    for axis in (0, 1):
        one, other = (
            [x.narrow(-2 + axis, first, x.shape[-2 + axis] - 1) for x in (offset, verbatim)] for first in (0, 1)
        )
        links.append(((one[0] == other[0]).all(0) & one[1] & other[1]).numpy())
    return joined(*links)[1].ravel()


def _cover(numbered: Tensor, sources: _Sources, window: int, shape: Sequence[int]) -> Tensor:
    """Spread region numbers (h, w) from the grid over the windows' pixels (H, W), largest first."""
    corners = torch.zeros(shape[0] - window + 1, shape[1] - window + 1, dtype=torch.float32)
    corners[sources.rows[:, None], sources.columns] = numbered.float()
    padded = F.pad(corners, [window - 1] * 4)
    return F.max_pool2d(padded[None], window, stride=1)[0].long()


def _use(place: Tensor, grids: list[tuple[int, int]]) -> float:
    """Entropy of source places (3, n) over the bins of all images, as a part of the largest possible."""
    size = torch.tensor(grids).T
    bins = size.clamp(max=BINS)
    image = place[0]
    row, column = place[1:] * bins[:, image] // size[:, image]
    first = torch.cat((torch.zeros(1, dtype=torch.long), bins.prod(0).cumsum(0)))
    counts = (first[image] + row * bins[1, image] + column).bincount(minlength=int(first[-1]))
    largest = math.log(min(len(counts), place.shape[1]))
    return float(torch.special.entr(counts.float() / counts.sum()).sum()) / largest if largest else 1.0
