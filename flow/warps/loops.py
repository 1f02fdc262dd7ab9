"""Reading an image at places, in a loop over these, compiled.

This module is compiled by numba when first used, so it is imported where an image is read.
"""

from functools import partial
from typing import Any

import numpy as np

from flow.warps import kernels
from kwatra.base.compiled import Compiled, jitted

inlined = partial(jitted, forceinline=True, error_model="numpy")
"""For loops that are compiled for each number of pixels along an axis."""

_FAR = 1e9
"""Beyond all images."""

_BLOCK = 64
"""So many places are weighed at a time: what that takes stays in the cache."""

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
    across, down, past = np.empty((_BLOCK, count)), np.empty((_BLOCK, count)), np.empty(_BLOCK)
    left, top = np.empty(_BLOCK, np.int64), np.empty(_BLOCK, np.int64)
    rows, columns = np.empty(count, np.int64), np.empty(count, np.int64)
    for first in range(low, high, _BLOCK):
        some = min(_BLOCK, high - first)
        _weigh(places[0, first : first + some], count, left, past, across)
        _weigh(places[1, first : first + some], count, top, past, down)
        for i in range(some):
            _found(left[i], width, wrap, columns)
            _found(top[i], height, wrap, rows)
            for channel in range(image.shape[0]):
                total = 0.0
                for j in range(count):
                    start, line = rows[j] * width, 0.0
                    for k in range(count):
                        line += across[i, k] * image[channel, start + columns[k]]
                    total += down[i, j] * line
                values[channel, first + i] = total


@inlined
def _weigh(places: Any, count: int, first: Any, past: Any, weights: Any) -> None:
    """Set the first pixels (n,) that are read along an axis for places (n,) on it, and all pixels' weights (n, count).

    past (n,): set to how far places lie past a pixel, so that the compiler weighs several at a time.
    """
    for i in range(len(places)):
        base = np.floor(places[i] + 0.5) if count == 1 else np.floor(places[i])
        past[i] = places[i] - base
        far = min(max(base, -_FAR), _FAR)
        first[i] = (np.int64(far) if far == far else 0) - (count - 1) // 2  # what is no number reads none somewhere
    for i in range(len(places)):
        if count == 1:
            weights[i, 0] = 1.0
        elif count == 2:
            weights[i, 0], weights[i, 1] = _linear(past[i])
        elif count == 4:
            weights[i, 0], weights[i, 1], weights[i, 2], weights[i, 3] = _catmull_rom(past[i])
        else:
            all_six = _lanczos(past[i])
            weights[i, 0], weights[i, 1], weights[i, 2] = all_six[0], all_six[1], all_six[2]
            weights[i, 3], weights[i, 4], weights[i, 5] = all_six[3], all_six[4], all_six[5]


@inlined
def _found(first: int, size: int, wrap: bool, pixels: Any) -> None:
    """The pixels that are there for those from a first one on."""
    for k in range(len(pixels)):
        pixels[k] = (first + k) % size if wrap else min(max(first + k, 0), size - 1)
