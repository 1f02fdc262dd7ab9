"""What seams of blocks that lie between an exemplar's pixels cost, in one loop over a window, compiled.

This module is compiled by numba when first used, so it is imported where a block is cut in.
"""

import math
from functools import partial
from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@partial(jitted, fastmath={"reassoc", "contract"})
def match(image: Any, old: Any, new: Any, cost: float, second: Any, first: Any) -> None:
    """Set what seams between each pixel of a window and the next along both axes cost, (2, H, W): see `Stock.matches`.

    image (h, w, C): an exemplar, in units in which colors differ by their distance, times cost. old, new (3, H, W):
    places, x first, and the angle of their copy.
    """
    _, height, width = old.shape
    shown, here = np.empty((height, width, image.shape[2]), np.float32), np.empty((height, width), np.float32)
    there = np.empty(image.shape[2], np.float32)
    for i in range(height):
        for j in range(width):
            _show(image, new[0, i, j], new[1, i, j], shown[i, j])
            _show(image, old[0, i, j], old[1, i, j], there)
            here[i, j] = _distance(there, shown[i, j])
    for i in range(height):
        for j in range(width):
            cos, sin = math.cos(old[2, i, j]), math.sin(old[2, i, j])
            for axis in range(2):
                x, y = (cos, sin) if axis else (-sin, cos)
                down, right = 1 - axis, axis
                if i + down < height and j + right < width:
                    _show(image, old[0, i, j] + x, old[1, i, j] + y, there)
                    second[axis, i, j] = cost * (here[i, j] + _distance(there, shown[i + down, j + right]))
                if i >= down and j >= right:
                    _show(image, old[0, i, j] - x, old[1, i, j] - y, there)
                    first[axis, i - down, j - right] = cost * (
                        here[i, j] + _distance(there, shown[i - down, j - right])
                    )


@partial(jitted, forceinline=True)
def _show(image: Any, x: Any, y: Any, shown: Any) -> None:
    """Read an image (h, w, C) between its pixels, bilinearly; beyond the border is the border."""
    height, width, channels = image.shape
    x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    left, top = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
    right, below = min(left + 1, width - 1), min(top + 1, height - 1)
    across, down = x - left, y - top
    for c in range(channels):
        upper = (1 - across) * image[top, left, c] + across * image[top, right, c]
        shown[c] = (1 - down) * upper + down * ((1 - across) * image[below, left, c] + across * image[below, right, c])


@partial(jitted, forceinline=True)
def _distance(one: Any, other: Any) -> Any:
    total = 0.0
    for c in range(len(one)):
        total += (one[c] - other[c]) * (one[c] - other[c])
    return math.sqrt(total)
