"""Patterns drawn over their image."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from skimage.draw import disk, line_aa
from torch import Tensor

from synth.metamorphosis.patterns.landmarks import Patterns

_Array = NDArray[Any]

ZOOM = 4
"""Pixels of the drawing for one of the image, so that its lines hide little."""
_FOUND, _GIVEN, _FIRST = (1.0, 0.0, 1.0), (0.0, 1.0, 0.3), (1.0, 1.0, 0.0)


def drawn(image: Tensor, patterns: Patterns) -> Tensor:
    """An image (C, H, W), four times as large, with its patterns over it: (3, 4 H, 4 W).

    Lines join the landmarks in order, magenta; the representative pattern is green, and the first landmark of each
    a yellow dot.
    """
    gray = image if len(image) == 3 else image[:1].expand(3, -1, -1)
    canvas = gray.repeat_interleave(ZOOM, 1).repeat_interleave(ZOOM, 2).permute(1, 2, 0).numpy().copy()
    for landmarks in patterns.found if patterns.found is not None else ():
        _draw(canvas, landmarks, patterns.closed, _FOUND)
    _draw(canvas, patterns.landmarks, patterns.closed, _GIVEN)
    return torch.from_numpy(canvas).permute(2, 0, 1).contiguous()


def _draw(canvas: _Array, landmarks: _Array, closed: bool, color: tuple[float, ...]) -> None:
    points = np.rint(landmarks * ZOOM + (ZOOM - 1) / 2).astype(int)
    ends = np.roll(points, -1, 0) if closed else points[1:]
    for (x, y), (to_x, to_y) in zip(points, ends, strict=False):
        rows, columns, weight = line_aa(y, x, to_y, to_x)
        _paint(canvas, rows, columns, weight, color)
    rows, columns = disk(tuple(points[0, ::-1]), ZOOM * 0.6)
    _paint(canvas, rows, columns, np.ones(len(rows)), _FIRST)


def _paint(canvas: _Array, rows: _Array, columns: _Array, weight: _Array, color: tuple[float, ...]) -> None:
    inside = (rows >= 0) & (rows < canvas.shape[0]) & (columns >= 0) & (columns < canvas.shape[1])
    rows, columns, weight = rows[inside], columns[inside], weight[inside, None]
    canvas[rows, columns] = (1 - weight) * canvas[rows, columns] + weight * np.array(color)
