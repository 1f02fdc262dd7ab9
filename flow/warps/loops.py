"""Reading an image at places, in a loop over these, compiled.

This module is compiled by numba when first used, so it is imported where an image is read.
"""

from functools import partial
from typing import Any

import numpy as np

from flow.warps import kernels
from kwatra.base.compiled import Compiled, jitted

inlined = partial(jitted, forceinline=True)
"""For loops that are compiled for each number of pixels along an axis."""

_FAR = 1e9
"""Beyond all images."""

_linear, _catmull_rom, _lanczos = inlined(kernels.linear), inlined(kernels.catmull_rom), inlined(kernels.lanczos)


@Compiled
def read(image: Any, shape: Any, places: Any, count: int, wrap: bool, values: Any, low: int, high: int) -> None:
    """Read an image (C, pixels) of `shape` (H, W) at places (2, N), x first, into values (C, N).

    count: how many pixels along each axis a place reads, as in `KERNELS`.
    """
    if count == 1:
        _read(image, shape, places, 1, wrap, values, low, high)
    elif count == 2:
        _read(image, shape, places, 2, wrap, values, low, high)
    elif count == 4:
        _read(image, shape, places, 4, wrap, values, low, high)
    else:
        _read(image, shape, places, 6, wrap, values, low, high)


@inlined
def _read(image: Any, shape: Any, places: Any, count: int, wrap: bool, values: Any, low: int, high: int) -> None:
    height, width = shape
    down, across = np.empty(count), np.empty(count)
    rows, columns = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(low, high):
        left, top = weighed(places[0, i], count, across), weighed(places[1, i], count, down)
        _found(left, width, wrap, columns)
        _found(top, height, wrap, rows)
        for channel in range(image.shape[0]):
            total = 0.0
            for j in range(count):
                first, line = rows[j] * width, 0.0
                for k in range(count):
                    line += across[k] * image[channel, first + columns[k]]
                total += down[j] * line
            values[channel, i] = total


@inlined
def weighed(place: Any, count: int, weights: Any) -> Any:
    """The first pixel that is read along an axis for a place on it, and, set, the pixels' weights."""
    base = np.floor(place + 0.5) if count == 1 else np.floor(place)
    f = place - base
    if count == 1:
        weights[0] = 1.0
    elif count == 2:
        weights[0], weights[1] = _linear(f)
    elif count == 4:
        weights[0], weights[1], weights[2], weights[3] = _catmull_rom(f)
    else:
        weights[0], weights[1], weights[2], weights[3], weights[4], weights[5] = _lanczos(f)
    far = min(max(base, -_FAR), _FAR)
    return (np.int64(far) if far == far else 0) - (count - 1) // 2  # what is no number reads no number somewhere


@inlined
def _found(first: int, size: int, wrap: bool, pixels: Any) -> None:
    """The pixels that are there for those from a first one on."""
    for k in range(len(pixels)):
        pixels[k] = (first + k) % size if wrap else min(max(first + k, 0), size - 1)
