"""Loops over the pixels of a frame that tell its copies apart: how each is turned, and where it ends; compiled.

What neighbors differ by is told once a row, in arrays that the compiler works on several pixels of at a time. This
module is compiled by numba when first used, so it is imported where a frame is worked on.
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
    above, below, beside = np.zeros((3, width)), np.zeros((3, width)), np.zeros((3, width + 1))
    for i in range(max(low - 1, 0), high):
        above, below = below, above
        x, y, there, last = source[0, i], source[1, i], inside[i], min(i + 1, height - 1)
        _tell_changes(x, y, there, source[0, last], source[1, last], inside[last], most, below[0], below[1], below[2])
        if last == i:
            below[:] = 0
        if i >= low:
            on = slice(1, width)
            _tell_changes(x, y, there, x[on], y[on], there[on], most, beside[0, on], beside[1, on], beside[2, on])
            _tell_turn(above, below, beside, turn[0, i], turn[1, i])


@jitted
def _tell_changes(
    x: Any, y: Any, there: Any, to_x: Any, to_y: Any, to: Any, most: float, right: Any, down: Any, near: Any
) -> None:
    """Set what a row of places (W,) changes by to another, and 1; 0 if one is not there or it is `most` px or more."""
    for j in range(len(to_x)):
        u, v = to_x[j] - x[j], to_y[j] - y[j]
        known = there[j] & to[j] & (u * u + v * v < most * most)
        right[j], down[j], near[j] = u if known else 0.0, v if known else 0.0, known


@jitted
def _tell_turn(above: Any, below: Any, beside: Any, sin: Any, cos: Any) -> None:
    """Set how the copies of a row are turned, by what it changes by from above, (3, W), to below, and sideways."""
    for j in range(len(sin)):
        down, right = 1 - above[2, j] * below[2, j] / 2, 1 - beside[2, j] * beside[2, j + 1] / 2  # half if both are
        sine = right * (beside[1, j] + beside[1, j + 1]) - down * (above[0, j] + below[0, j])
        cosine = right * (beside[0, j] + beside[0, j + 1]) + down * (above[1, j] + below[1, j])
        square = sine * sine + cosine * cosine
        length = math.sqrt(square if square > 0 else 1.0)
        sin[j], cos[j] = sine / length, (cosine if square > 0 else 1.0) / length


@Compiled
def find_seams(
    source: Any, inside: Any, beside: Any, steps: Any, jump: float, seam: Any, goes_on: Any, low: int, high: int
) -> None:
    """Set where neighbors of pixels belong to other copies, (n, H, W), and where those go on to in the pixel.

    steps (n, 2): rows and columns to the neighbors; goes_on (n, 2, H, W): x first, set where there are neighbors; rows
    from low to high.
    source (2, H, W), inside (H, W), and what copies change by to the right, beside (2, H, W): of the frame; jump: that
    between two copies, in px.
    """
    height, width = inside.shape
    for k in range(len(steps)):
        down, right = steps[k]
        own = slice(max(-right, 0), width - max(right, 0))
        other = slice(own.start + right, own.stop + right)
        for i in range(low, high):
            seam[k, i], r = False, i + down
            if r < 0 or r >= height:
                continue
            x, y, there = source[0, i, own], source[1, i, own], inside[i, own]
            to_x, to_y, to = source[0, r, other], source[1, r, other], inside[r, other]
            cos, sin, here = beside[0, r, other], beside[1, r, other], seam[k, i, own]
            on_x, on_y = goes_on[k, 0, i, own], goes_on[k, 1, i, own]
            for j in range(len(x)):
                on_x[j], on_y[j] = to_x[j] - right * cos[j] + down * sin[j], to_y[j] - right * sin[j] - down * cos[j]
                u, v = on_x[j] - x[j], on_y[j] - y[j]
                here[j] = there[j] & to[j] & (u * u + v * v >= jump * jump)


@Compiled
def tell_area(source: Any, beside: Any, jump: float, off: Any, low: int, high: int) -> None:
    """Set by how much more or less than their own area pixels show, in rows from low to high, (H, W).

    It is squared and at most 1; 0 between copies. source (2, H, W); beside (2, H, W): what copies change by to the
    right; jump: that between two copies, in px.
    """
    _, height, width = source.shape
    for i in range(low, high):
        off[i] = 0
        x, y, cos, sin, to = source[0, i], source[1, i], beside[0, i], beside[1, i], off[i]
        under_x, under_y = source[0, min(i + 1, height - 1)], source[1, min(i + 1, height - 1)]
        for j in range(width - 1 if i + 1 < height else 0):
            a, b, c, d = under_x[j] - x[j], under_y[j] - y[j], x[j + 1] - x[j], y[j + 1] - y[j]
            down = (a + sin[j]) * (a + sin[j]) + (b - cos[j]) * (b - cos[j])
            right = (c - cos[j]) * (c - cos[j]) + (d - sin[j]) * (d - sin[j])
            area = c * b - d * a - 1
            to[j] = min(area * area, 1.0) if (down < jump * jump) & (right < jump * jump) else 0.0


@Compiled
def tidy(
    source: Any, inside: Any, free: Any, turn: Any, steps: Any, jump: float, few: int, recent: Any, after: Any,
    joined: Any, low: int, high: int,
) -> None:  # fmt: skip
    """Set rows from low to high of source coordinates (2, H, W) in which lone pixels have joined the copy around them.

    inside (H, W): where there is texture; free (H, W): what may join. turn (2, H, W): how copies are turned, as
    `tell_turns` sets it; steps (8, 2): rows and columns to the pixels around one; jump: what is between two copies, in
    px. A pixel at a seam is lone when no more than `few` of these belong to its copy. recent (H, W): what has just
    changed; where nothing has within 2 px, nothing joins. joined (H, W): set to where pixels have joined.
    """
    width = inside.shape[1]
    above, below, beside = np.zeros((3, width + 1), np.bool_)
    for i in range(low, high):
        joined[i] = False
        for j in range(width):
            after[0, i, j], after[1, i, j] = source[0, i, j], source[1, i, j]
        if not recent[max(i - 2, 0) : i + 3].any():
            continue
        _part_row(source, turn, i, jump, above, below, beside)
        for j in range(width):
            seam = above[j] | below[j] | beside[j] | beside[j + 1]
            if seam and free[i, j] and recent[max(i - 2, 0) : i + 3, max(j - 2, 0) : j + 3].any():
                joined[i, j] = _joins(source, inside, turn, steps, jump, few, i, j, after)


@jitted
def _part_row(source: Any, turn: Any, i: int, jump: float, above: Any, below: Any, beside: Any) -> None:
    """Set where row i of copies (2, H, W) is parted from the rows above and below it, and its pixels j - 1 and j.

    turn (2, H, W): how they are turned; all three are (W + 1,). The first row and the last are as if copies went on.
    """
    up, down = max(i - 1, 0), min(i + 1, source.shape[1] - 1)
    _part(source[:, up], source[:, i], turn[:, up], i - up, 0, jump, above)
    _part(source[:, i], source[:, down], turn[:, i], down - i, 0, jump, below)
    _part(source[:, i], source[:, i, 1:], turn[:, i], 0, 1, jump, beside[1:])


@jitted
def _part(source: Any, other: Any, turn: Any, down: int, right: int, jump: float, parts: Any) -> None:
    """Set where a row of copies (2, W) does not go on, so many steps down and to the right, to another row (2, W).

    turn (2, W): how they are turned.
    """
    x, y, sin, cos, to_x, to_y = source[0], source[1], turn[0], turn[1], other[0], other[1]
    for j in range(len(to_x)):
        u = to_x[j] - (x[j] + (right * cos[j] - down * sin[j]))
        v = to_y[j] - (y[j] + (right * sin[j] + down * cos[j]))
        parts[j] = u * u + v * v >= jump * jump


@jitted
def _joins(source: Any, inside: Any, turn: Any, steps: Any, jump: float, few: int, i: int, j: int, after: Any) -> bool:
    """Whether a pixel joins the copy around it, as `tidy` says, and then set it."""
    near, there = np.empty((8, 2), source.dtype), np.empty(8, np.bool_)
    own = 0
    for k in range(8):
        r = min(max(i + steps[k, 0], 0), inside.shape[0] - 1)
        c = min(max(j + steps[k, 1], 0), inside.shape[1] - 1)
        near[k, 0], near[k, 1] = _onward(source, turn, r, c, i - r, j - c)
        there[k] = inside[r, c]
        own += there[k] and _apart(near[k, 0], near[k, 1], source[0, i, j], source[1, i, j]) < jump * jump
    if own > few:
        return False
    most, copy = 0, 0
    for k in range(8):
        alike = 0
        for n in range(8):
            both = there[k] and there[n]
            alike += both and _apart(near[n, 0], near[n, 1], near[k, 0], near[k, 1]) < jump * jump
        if alike > most:
            most, copy = alike, k
    if most <= own + 1:
        return False
    after[0, i, j], after[1, i, j] = near[copy, 0], near[copy, 1]
    return True


@Compiled
def hide(
    source: Any, turn: Any, inside: Any, free: Any, depth: Any, steps: Any, jump: float, length: float, odd: int,
    low: int, high: int,
) -> None:  # fmt: skip
    """Have pixels beside seams go over to the copy beside them that hides these, in rows from low to high.

    source, turn (2, H, W): coordinates, and how copies are turned, as `tell_turns` sets it; both are changed. inside
    (H, W): where there is texture; free (H, W): what may change, of every other pixel: odd (0 or 1) says of which.
    depth (h, w): how deep in its element each place of the exemplar lies; steps (4, 2): rows and columns to the pixels
    beside one; jump: what is between two copies, in px; length: what a seam costs besides, per pixel.
    """
    width = inside.shape[1]
    above, below, beside = np.zeros((3, width + 1), np.bool_)
    for i in range(low, high):
        _part_row(source, turn, i, jump, above, below, beside)
        for j in range((i + odd) % 2, width, 2):
            if (above[j] | below[j] | beside[j] | beside[j + 1]) and free[i, j] and inside[i, j]:
                _hide(source, turn, inside, depth, steps, jump, length, i, j)


@jitted
def _hide(
    source: Any, turn: Any, inside: Any, depth: Any, steps: Any, jump: float, length: float, i: int, j: int
) -> None:
    """Have a pixel go over, as `hide` says, if that makes the seams around it cost less."""
    height, width = inside.shape
    near, deep, there = np.empty((4, 2), source.dtype), np.empty(4, depth.dtype), np.zeros(4, np.bool_)
    for k in range(len(steps)):
        r, c = i + steps[k, 0], j + steps[k, 1]
        if 0 <= r < height and 0 <= c < width and inside[r, c]:
            near[k, 0], near[k, 1] = _onward(source, turn, r, c, i - r, j - c)
            deep[k], there[k] = _deep(depth, source[0, r, c], source[1, r, c]), True
    least, copy = _seams(source[0, i, j], source[1, i, j], near, deep, there, depth, jump, length), -1
    for k in range(len(steps)):
        cost = _seams(near[k, 0], near[k, 1], near, deep, there, depth, jump, length) if there[k] else least
        if cost < least:
            least, copy = cost, k
    if copy >= 0:
        r, c = i + steps[copy, 0], j + steps[copy, 1]
        source[0, i, j], source[1, i, j] = near[copy, 0], near[copy, 1]
        turn[0, i, j], turn[1, i, j] = turn[0, r, c], turn[1, r, c]


@jitted
def _seams(x: Any, y: Any, near: Any, deep: Any, there: Any, depth: Any, jump: float, length: float) -> Any:
    """What the seams around a pixel cost that shows a place, where those beside it, so deep (4,), go on to (4, 2)."""
    cost, own = np.float32(0), _deep(depth, x, y)
    for k in range(4):
        if there[k] and _apart(near[k, 0], near[k, 1], x, y) >= jump * jump:
            cost += min(own, deep[k]) + length
    return cost


@jitted
def _deep(depth: Any, x: Any, y: Any) -> Any:
    """How deep (h, w) in its element the pixel nearest to a place lies."""
    row, column = int(np.rint(y)), int(np.rint(x))
    return depth[min(max(row, 0), depth.shape[0] - 1), min(max(column, 0), depth.shape[1] - 1)]


@jitted
def _onward(source: Any, turn: Any, i: int, j: int, down: int, right: int) -> Any:
    """Where the copy that a pixel shows goes on so many pixels down and to the right."""
    sin, cos = turn[0, i, j], turn[1, i, j]
    return source[0, i, j] + (right * cos - down * sin), source[1, i, j] + (right * sin + down * cos)


@jitted
def _apart(x: Any, y: Any, u: Any, v: Any) -> Any:
    """The square of how far two places are apart."""
    return (x - u) * (x - u) + (y - v) * (y - v)
