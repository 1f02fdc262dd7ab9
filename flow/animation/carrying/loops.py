"""Loops over the pixels of a frame, or of its windows, that carrying it and telling its wear take, compiled.

This module is compiled by numba when first used, so it is imported where a frame is worked on.
"""

import math
from typing import Any

import numpy as np

from kwatra.base.compiled import Compiled


@Compiled
def carry(
    source: Any, inside: Any, beside: Any, places: Any, jump: float, after: Any, first: Any, low: int, high: int
) -> None:
    """Set what flows from places (2, N), x first, to pixels from low to high: source coordinates (2, N).

    source (2, H, W), inside (H, W), and what copies change by to the right, beside (2, H, W): of the frame before;
    jump: that between two copies, in px. first (N,): set to the pixels, counted row by row, whose copies it shows.
    """
    height, width = inside.shape
    for i in range(low, high):
        x = min(max(places[0, i], 0.0), width - 1.0)
        y = min(max(places[1, i], 0.0), height - 1.0)
        left, top = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
        column, row = int(np.rint(x)), int(np.rint(y))
        cos, sin = beside[0, row, column], beside[1, row, column]
        across, down, mass = 0.0, 0.0, 0.0
        for k in range(4):
            r, c = min(top + k // 2, height - 1), min(left + k % 2, width - 1)
            if not inside[r, c]:
                continue
            under, over = row - r, column - c
            u = source[0, r, c] - source[0, row, column] + over * cos - under * sin
            v = source[1, r, c] - source[1, row, column] + over * sin + under * cos
            if u * u + v * v < jump * jump:
                share = abs(1 - k // 2 - (y - top)) * abs(1 - k % 2 - (x - left))
                across, down, mass = across + share * u, down + share * v, mass + share
        if mass > 0:
            across, down = across / mass, down / mass
        under, over = places[1, i] - row, places[0, i] - column
        after[0, i] = source[0, row, column] + (over * cos - under * sin) + across
        after[1, i] = source[1, row, column] + (over * sin + under * cos) + down
        first[i] = row * width + column


@Compiled
def compare(
    image: Any, corners: Any, exemplar: Any, there: Any, middle: Any, angle: Any, weight: Any, apart: Any, low: int,
    high: int,
) -> None:  # fmt: skip
    """Set the squared distances of windows from low to high of an image (H, W, C) to those of an exemplar (h, w, C).

    corners (N, 2): where windows start; there (N, 2): where those of the exemplar do, or, of copies turned by an angle
    (N,) that is not 0, the place (2, N), x first, in their middles. weight (*width, C): that of a window's values.
    """
    height, width, channels = exemplar.shape
    span = weight.shape[1] * channels
    own, others = image.reshape((image.shape[0], -1)), exemplar.reshape((height, -1))
    counts = weight.reshape((weight.shape[0], -1))
    for i in range(low, high):
        total = np.float32(0)
        for j in range(weight.shape[0] if angle[i] == 0 else 0):
            here = own[corners[i, 0] + j, corners[i, 1] * channels : corners[i, 1] * channels + span]
            line = others[there[i, 0] + j, there[i, 1] * channels : there[i, 1] * channels + span]
            count = counts[j]
            for k in range(span):
                off = here[k] - line[k]
                total += count[k] * off * off
        cos, sin = math.cos(angle[i]), math.sin(angle[i])
        for j in range(weight.shape[0] if angle[i] != 0 else 0):
            for k in range(weight.shape[1]):
                here = image[corners[i, 0] + j, corners[i, 1] + k]
                under, over = j - weight.shape[0] // 2, k - weight.shape[1] // 2
                x = min(max(middle[0, i] + over * cos - under * sin, 0.0), width - 1.0)
                y = min(max(middle[1, i] + over * sin + under * cos, 0.0), height - 1.0)
                left, top = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
                right, below = min(left + 1, width - 1), min(top + 1, height - 1)
                across, down = x - left, y - top
                for c in range(channels):
                    upper = (1 - across) * exemplar[top, left, c] + across * exemplar[top, right, c]
                    lower = (1 - across) * exemplar[below, left, c] + across * exemplar[below, right, c]
                    off = here[c] - ((1 - down) * upper + down * lower)
                    total += weight[j, k, c] * off * off
        apart[i] = total


@Compiled
def spread(corners: Any, values: Any, falloff: Any, made: Any, low: int, high: int) -> None:
    """Set rows from low to high of the sum (H, W) of windows that start at corners (N, 2), values (N,) times a falloff.

    falloff (*width).
    """
    made[low:high] = 0
    tall, wide = falloff.shape
    for i in range(len(corners)):
        top, left = corners[i, 0], corners[i, 1]
        for row in range(max(top, low), min(top + tall, high)):
            line, part = made[row, left : left + wide], falloff[row - top]
            for k in range(wide):
                line[k] += values[i] * part[k]


@Compiled
def blur(image: Any, weights: Any, smooth: Any, low: int, high: int) -> None:
    """Set an image (C, H, W) convolved with weights (2 r + 1,) along both axes; rows of all channels from low to high.

    Beyond its border is the border.
    """
    _, height, width = image.shape
    reach = len(weights) // 2
    line = np.empty(width + 2 * reach, image.dtype)
    for row in range(low, high):
        channel, i = row // height, row % height
        middle, to = line[reach : reach + width], smooth[channel, i]
        middle[:], to[:] = 0, 0
        for k in range(len(weights)):
            weight, above = weights[k], image[channel, min(max(i + k - reach, 0), height - 1)]
            for j in range(width):
                middle[j] += weight * above[j]
        line[:reach], line[reach + width :] = middle[0], middle[-1]
        for k in range(len(weights)):
            weight, beside = weights[k], line[k : k + width]
            for j in range(width):
                to[j] += weight * beside[j]
