"""Regions of joined pixels, in compiled loops (`regions`).

This module is compiled by numba when first used, so it is imported where regions are looked for.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def number_regions(down: Any, right: Any, number: Any) -> Any:
    """Set the number of the region that each pixel belongs to (H, W); returns how many there are. See `regions`."""
    height, width = number.shape
    root = np.arange(height * width)
    for i in range(height):
        for j in range(width):
            pixel = i * width + j
            if j + 1 < width and right[i, j]:
                join(root, pixel, pixel + 1)
            if i + 1 < height and down[i, j]:
                join(root, pixel, pixel + width)
    count = 0
    for i in range(height):
        for j in range(width):
            first = root_of(root, i * width + j)
            if first == i * width + j:
                number[i, j] = count
                count += 1
            else:
                number[i, j] = number[first // width, first % width]
    return count


@jitted
def join(root: Any, one: Any, other: Any) -> None:
    """Join the regions of two pixels; root (pixels): an earlier one of a pixel's region, of its first one itself."""
    one, other = root_of(root, one), root_of(root, other)
    root[max(one, other)] = min(one, other)


@jitted
def root_of(root: Any, pixel: Any) -> Any:
    """The first pixel of a pixel's region."""
    while root[pixel] != pixel:
        root[pixel] = root[root[pixel]]
        pixel = root[pixel]
    return pixel
