"""Where neighborhoods are pasted: in each cell of a grid at the one center that fits best (Ruiters et al. 2010, 4.4).

For made-up neighborhoods there need not be one that fits at a given place, while there is one a pixel further on.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra import FreeWindows, Step
from kwatra.source import CHUNK
from kwatra.windows import Layout

CELLS = 4
"""Cells along a window: so every pixel lies under some sixteen windows."""

TRIED = 2
"""Of a cell every second pixel is tried, along both axes: a fourth of the cost."""


def spread(shape: tuple[int, ...], width: tuple[int, ...], wraps: tuple[bool, ...], cells: int = CELLS) -> FreeWindows:
    """Windows `cells` times closer together than they are wide, those at a plain border flush with it."""
    lines = []
    for size, w, wrap in zip(shape, width, wraps, strict=True):
        last, cell = size - 1 if wrap else size - w, max(w // cells, 1)
        line = torch.arange(0, last + 1, cell)
        lines.append(line if wrap or line[-1] == last else torch.cat([line, torch.tensor([last])]))
    return FreeWindows(shape, width, torch.cartesian_prod(*lines).view(-1, len(lines)), wraps)


def regular(step: Step) -> Layout:
    """Windows on a grid: see `spread`."""
    return spread(step.shape, step.width, step.wraps)


@dataclass(frozen=True)
class BestCenters:
    """A layout: for each cell the window in it that is most like one of the source's; at a plain border the outermost.

    known (N, 2): first pixels that are tried in any case, such as those of the frame before.
    """

    known: Tensor | None = None

    def __call__(self, step: Step) -> Layout:
        """The windows of a step. Memory: bands of windows, and one place for each cell."""
        if step.image is None:
            return regular(step)
        places, errors = [], []
        most = max(CHUNK // step.source.metric.weight.numel(), 1)
        for band in FreeWindows(step.shape, step.width, self._tried(step), step.wraps).bands(most):
            described = step.source.describe(band.gather(step.image))
            found = step.source.nearest(described, 1, "approximate")
            errors.append(step.source.estimate(described, found)[:, 0])
            places.append(band.corners)
        place, error = torch.cat(places), torch.cat(errors)
        cell = torch.zeros(len(place), dtype=torch.long, device=place.device)
        for axis, (size, width, side, wraps) in enumerate(_axes(step)):
            cell = cell * (size + 1) + _cell(place[:, axis], size, width, side, wraps)
        order = error.argsort(stable=True)
        order = order[cell[order].argsort(stable=True)]
        first = torch.ones_like(order, dtype=torch.bool)
        first[1:] = cell[order][1:] != cell[order][:-1]
        return FreeWindows(step.shape, step.width, place[order[first]], step.wraps)

    def _tried(self, step: Step) -> Tensor:
        """First pixels (N, 2) of windows: every second along both axes, the border's, and those that are known."""
        lines = []
        for size, width, _, wraps in _axes(step):
            last = size - 1 if wraps else size - width
            lines.append(torch.cat([torch.arange(0, last + 1, TRIED), torch.tensor([last])]).unique())
        tried = torch.cartesian_prod(*lines).view(-1, len(lines))
        tried = tried if self.known is None else torch.cat([self.known, tried])
        return tried


def _axes(step: Step) -> list[tuple[int, int, int, bool]]:
    """Of each axis the image's size, the window's width, the cell's side, and whether it is periodic."""
    return [
        (size, width, max(width // CELLS, 1), wraps)
        for size, width, wraps in zip(step.shape, step.width, step.wraps, strict=True)
    ]


def _cell(place: Tensor, size: int, width: int, side: int, wraps: bool) -> Tensor:
    """The number of the cell that a first pixel lies in; at a plain border the outermost are cells of their own."""
    last = size - width
    number = place // side + 1
    if wraps:
        return number
    return torch.where(place == 0, 0, torch.where(place == last, size, number))
