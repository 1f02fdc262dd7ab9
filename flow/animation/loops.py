"""Loops over the pixels of a frame, or of its windows, that carrying it and telling its wear take, compiled.

This module is compiled by numba when first used, so it is imported where a frame is worked on.
"""

import math
from typing import Any

import numpy as np

from kwatra.base.compiled import Compiled, jitted


@Compiled
def tell_turns(source: Any, inside: Any, most: float, turn: Any, low: int, high: int) -> None:
    """Set how copies are turned in rows from low to high of source coordinates (2, H, W).

    turn (2, H, W): the angle's sine and cosine. inside (H, W): where there is texture; most: pixels tell
    it that show places less than so many px apart.
    """
    _, height, width = turn.shape
    for i in range(low, high):
        for j in range(width):
            sine, cosine = 0.0, 0.0
            for axis in range(2):
                x, y, count = 0.0, 0.0, 0
                for back in range(2):
                    p, q = (i - back, j) if axis == 0 else (i, j - back)
                    r, s = (p + 1, q) if axis == 0 else (p, q + 1)
                    if p < 0 or q < 0 or r >= height or s >= width or not (inside[p, q] and inside[r, s]):
                        continue
                    right, down = source[0, r, s] - source[0, p, q], source[1, r, s] - source[1, p, q]
                    if right * right + down * down < most * most:
                        x, y, count = x + right, y + down, count + 1
                x, y = x / max(count, 1), y / max(count, 1)
                sine, cosine = (sine - x, cosine + y) if axis == 0 else (sine + y, cosine + x)
            length = math.sqrt(sine * sine + cosine * cosine)
            turn[0, i, j], turn[1, i, j] = (sine / length, cosine / length) if length > 0 else (0.0, 1.0)


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


@Compiled
def find_seams(
    source: Any, inside: Any, beside: Any, steps: Any, jump: float, seam: Any, goes_on: Any, low: int, high: int
) -> None:
    """Set where neighbors of pixels belong to other copies, (n, H, W), and where those go on to in the pixel.

    steps (n, 2): rows and columns to the neighbors; goes_on (n, 2, H, W): x first, set at seams; rows from low to high.
    source (2, H, W), inside (H, W), and what copies change by to the right, beside (2, H, W): of the frame; jump: that
    between two copies, in px.
    """
    height, width = inside.shape
    for i in range(low, high):
        for j in range(width):
            for k in range(len(steps)):
                seam[k, i, j] = False
                r, c = i + steps[k, 0], j + steps[k, 1]
                if r < 0 or c < 0 or r >= height or c >= width or not (inside[i, j] and inside[r, c]):
                    continue
                cos, sin = beside[0, r, c], beside[1, r, c]
                x = source[0, r, c] - steps[k, 1] * cos + steps[k, 0] * sin
                y = source[1, r, c] - steps[k, 1] * sin - steps[k, 0] * cos
                right, down = x - source[0, i, j], y - source[1, i, j]
                seam[k, i, j] = right * right + down * down >= jump * jump
                goes_on[k, 0, i, j], goes_on[k, 1, i, j] = x, y


@Compiled
def tidy(
    source: Any, inside: Any, free: Any, turn: Any, steps: Any, jump: float, few: int, after: Any, joins: Any, low: int,
    high: int,
) -> None:  # fmt: skip
    """Set rows from low to high of source coordinates (2, H, W) in which lone pixels have joined the copy around them.

    inside (H, W): where there is texture; free (H, W): what may join. turn (2, H, W): how copies are turned, as
    `tell_turns` sets it; steps (8, 2): rows and columns to the pixels around one; jump: what is between two copies, in
    px. A pixel at a seam is lone when no more than `few` of these belong to its copy. joins (H,): set to how many in
    each row have joined.
    """
    near, there = np.empty((8, 2), source.dtype), np.empty(8, np.bool_)
    for i in range(low, high):
        joins[i] = 0
        for j in range(inside.shape[1]):
            after[0, i, j], after[1, i, j] = source[0, i, j], source[1, i, j]
            if not (free[i, j] and _at_seam(source, turn, i, j, jump)):
                continue
            own = 0
            for k in range(8):
                r = min(max(i + steps[k, 0], 0), len(inside) - 1)
                c = min(max(j + steps[k, 1], 0), inside.shape[1] - 1)
                near[k, 0], near[k, 1] = _onward(source, turn, r, c, i - r, j - c)
                there[k] = inside[r, c]
                own += there[k] and _apart(near[k, 0], near[k, 1], source[0, i, j], source[1, i, j]) < jump * jump
            if own > few:
                continue
            most, copy = 0, 0
            for k in range(8):
                alike = 0
                for n in range(8):
                    both = there[k] and there[n]
                    alike += both and _apart(near[n, 0], near[n, 1], near[k, 0], near[k, 1]) < jump * jump
                if alike > most:
                    most, copy = alike, k
            if most > own + 1:
                after[0, i, j], after[1, i, j] = near[copy, 0], near[copy, 1]
                joins[i] += 1


@jitted
def _at_seam(source: Any, turn: Any, i: int, j: int, jump: float) -> bool:
    """Whether a pixel and one beside it belong to two copies; whichever comes first tells where its own goes on."""
    _, height, width = source.shape
    for axis in range(2):
        for back in range(2):
            r, c = (i - back, j) if axis == 0 else (i, j - back)
            down, right = 1 - axis, axis
            if min(r, c) >= 0 and r + down < height and c + right < width:
                x, y = _onward(source, turn, r, c, down, right)
                if _apart(source[0, r + down, c + right], source[1, r + down, c + right], x, y) >= jump * jump:
                    return True
    return False


@jitted
def _onward(source: Any, turn: Any, i: int, j: int, down: int, right: int) -> Any:
    """Where the copy that a pixel shows goes on so many pixels down and to the right."""
    sin, cos = turn[0, i, j], turn[1, i, j]
    return source[0, i, j] + (right * cos - down * sin), source[1, i, j] + (right * sin + down * cos)


@jitted
def _apart(x: Any, y: Any, u: Any, v: Any) -> Any:
    """The square of how far two places are apart."""
    return (x - u) * (x - u) + (y - v) * (y - v)
