"""Cells warped along rays from their middles, in compiled loops; windows and copies are as in `loops`.

This module is compiled by numba when first used, so it is imported where cells are fitted.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.pieces.cells.loops import window

STEP = 0.5
"""px between points of a ray that are looked at."""


@jitted
def seen_from_middle(shapes: Any, rays: Any, seen: Any, gaps: Any) -> None:
    """Set the share of each element that is seen from the middle of its cell (n,), 0 to 1, along so many rays.

    gaps (n, rays): how wide the ground is between the element and its cell's border along each, px.
    """
    cell_at = np.empty(rays)
    seen[0], gaps[0] = 0, 0
    for cell in range(1, len(seen)):
        away, element = window(shapes, shapes.away, cell), window(shapes, shapes.element, cell)
        middle, _ = _deepest(away, away)
        _reach(_side(element), middle, gaps[cell])
        _reach(away, middle, cell_at)
        area = np.square(gaps[cell]).sum() * np.pi / rays
        seen[cell] = min(area / max(element.sum(), 1), 1.0) if element[middle] else 0.0
        gaps[cell] = np.maximum(cell_at - gaps[cell], 0)


@jitted
def warp(
    shapes: Any, cell: Any, first: Any, rays: Any, most: Any, gaps: Any, best: Any, second: Any, owner: Any,
    written: Any, where: Any,
) -> None:  # fmt: skip
    """Have the share of each copy show its whole cell: set places `where` (2, H, W) that are `written` (H, W).

    rays: along so many the border of a share becomes that of the cell. most: elements are stretched and squeezed along
    one by no more, while they need not be. gaps (2,): as of `_shown`. best, second, owner: as of `divide`.
    """
    share_at, cell_at, element_at, shown_at = np.empty(rays), np.empty(rays), np.empty(rays), np.empty(rays)
    some = _some(len(cell), owner, written)
    for m in range(len(cell)):
        if not some[m]:
            continue
        away, element = window(shapes, shapes.away, cell[m]), window(shapes, shapes.element, cell[m])
        outside = _outside(away, first[m], m, best, second, owner)
        middle, deepest = _deepest(away, outside)
        if deepest == 0:
            continue
        _reach(outside, middle, share_at)
        _reach(away, middle, cell_at)
        _reach(_side(element), middle, element_at)
        _shown(share_at, cell_at, element_at, gaps, shown_at)
        for i in range(away.shape[0]):
            for j in range(away.shape[1]):
                y, x = i + first[m, 0], j + first[m, 1]
                if 0 <= y < owner.shape[0] and 0 <= x < owner.shape[1] and owner[y, x] == m and written[y, x]:
                    scale = _scale(i - middle[0], j - middle[1], share_at, cell_at, element_at, shown_at, most)
                    row, column = _inside(away, middle, (i - middle[0]) * scale, (j - middle[1]) * scale)
                    where[0, y, x] = row + shapes.first[cell[m], 0]
                    where[1, y, x] = column + shapes.first[cell[m], 1]


@jitted
def _some(copies: Any, owner: Any, written: Any) -> Any:
    """Of which copies (m,) anything is written."""
    some = np.zeros(copies, np.bool_)
    for i in range(owner.shape[0]):
        for j in range(owner.shape[1]):
            if written[i, j]:
                some[owner[i, j]] = True
    return some


@jitted
def _side(element: Any) -> Any:
    """Below 0 in an element (h, w), above it beyond."""
    return np.where(element, np.float32(-0.5), np.float32(0.5))


@jitted
def _outside(away: Any, first: Any, m: Any, best: Any, second: Any, owner: Any) -> Any:
    """How far outside of a copy's share pixels of its window are, px, below 0 inside; beyond an output as `away`."""
    outside = away.copy()
    for i in range(away.shape[0]):
        for j in range(away.shape[1]):
            y, x = i + first[0], j + first[1]
            if 0 <= y < owner.shape[0] and 0 <= x < owner.shape[1]:
                if owner[y, x] == m:
                    outside[i, j] = max(best[y, x] - second[y, x], -2 * len(away)) / 2
                else:
                    outside[i, j] = max(away[i, j] - best[y, x], 0.5) / 2
    return outside


@jitted
def _deepest(one: Any, other: Any) -> Any:
    """The pixel of a window (h, w) that is deepest inside of two things, and how deep, 0 where none is in both."""
    middle, deepest = (0, 0), np.float32(0)
    for i in range(one.shape[0]):
        for j in range(one.shape[1]):
            if max(one[i, j], other[i, j]) < deepest:
                middle, deepest = (i, j), max(one[i, j], other[i, j])
    return middle, deepest


@jitted
def _reach(outside: Any, middle: Any, at: Any) -> None:
    """Set how far it is from the middle of a window along rays (k,), evenly around, until values are no longer < 0.

    In the mean over two pixels of the border, as what is told by pixels has steps.
    """
    reached = np.empty(len(at))
    for k in range(len(at)):
        angle = 2 * np.pi * k / len(at)
        down, right = np.sin(angle), np.cos(angle)
        far, before, now = 0.0, outside[middle], outside[middle]
        while now < 0:
            far, before = far + STEP, now
            row, column = middle[0] + down * far, middle[1] + right * far
            if not (0 <= row < outside.shape[0] - 1 and 0 <= column < outside.shape[1] - 1):
                break
            now = _between(outside, row, column)
        reached[k] = max(far - STEP * now / (now - before), STEP) if now >= 0 and now > before else max(far, STEP)
    _spread(reached, round(len(at) / (2 * np.pi * reached.mean())), at)


@jitted
def _spread(values: Any, near: Any, means: Any) -> None:
    """Set the means of values (k,) that lie around a circle and their so many neighbors on both sides."""
    count = len(values)
    near = min(near, count // 8)
    for k in range(count):
        total = 0.0
        for n in range(k - near, k + near + 1):
            total += values[n % count]
        means[k] = total / (2 * near + 1)


@jitted
def _between(values: Any, row: Any, column: Any) -> Any:
    """Values (h, w) between pixels, bilinear."""
    i, j = int(row), int(column)
    down, right = row - i, column - j
    upper = values[i, j] * (1 - right) + values[i, j + 1] * right
    return upper * (1 - down) + (values[i + 1, j] * (1 - right) + values[i + 1, j + 1] * right) * down


@jitted
def _shown(share_at: Any, cell_at: Any, element_at: Any, gaps: Any, shown_at: Any) -> None:
    """Set how far an element reaches in its share along rays (k,).

    The ground around it stays as wide as it is between gaps (2,), px: elements are squeezed that leave less than the
    first, or than they have, and stretched that leave more than the second. Where ground is wider than narrow gaps
    outlines stay as smooth as that: no more than their neighbors are elements drawn out into corners of their share.
    """
    rays = len(share_at)
    ratios, least = np.empty(rays), np.empty(rays)
    for k in range(rays):
        element_at[k] = min(element_at[k], cell_at[k])
        share, gap = share_at[k], cell_at[k] - element_at[k]
        most = max(element_at[k], share - max(gap, gaps[1]))
        ratios[k] = min(most, max(share - min(gap, gaps[0]), 0.5 * share)) / element_at[k]
    near = min(round(max(gaps[1] - gaps[0], 0) * rays / (2 * np.pi * element_at.mean())), rays // 8)
    for k in range(rays):
        least[k] = ratios[k]
        for n in range(k - near, k + near + 1):
            least[k] = min(least[k], ratios[n % rays])
    _spread(least, near, shown_at)
    shown_at *= element_at


@jitted
def _scale(down: Any, right: Any, share_at: Any, cell_at: Any, element_at: Any, shown_at: Any, most: Any) -> Any:
    """By how much further from the middle that lies in a cell which is shown so far from it in the share."""
    far = np.sqrt(down * down + right * right)
    if far == 0:
        return 1.0
    at = np.arctan2(down, right) / (2 * np.pi) * len(share_at) % len(share_at)
    k, part = int(at) % len(share_at), at - int(at)
    after = (k + 1) % len(share_at)
    share = share_at[k] * (1 - part) + share_at[after] * part
    cell = cell_at[k] * (1 - part) + cell_at[after] * part
    element = element_at[k] * (1 - part) + element_at[after] * part
    shown = shown_at[k] * (1 - part) + shown_at[after] * part
    if far >= shown:
        ground = min(element + 0.7, cell)  # whose pixels are no longer the element's
        return (ground + (min(far, share) - shown) * (cell - ground) / max(share - shown, 1e-3)) / far
    rigid = min((most * shown - element) / (most - 1), (most * element - shown) / (most - 1))
    rigid = min(max(rigid, 0.1 * min(shown, element)), min(shown, element))
    if far <= rigid:
        return 1.0
    return (rigid + (far - rigid) * (element - rigid) / (shown - rigid)) / far


@jitted
def _inside(away: Any, middle: Any, down: Any, right: Any) -> Any:
    """The pixel of a window so far from its middle, or the last before it that is in the cell."""
    row, column = int(np.rint(middle[0] + down)), int(np.rint(middle[1] + right))
    while not (0 <= row < away.shape[0] and 0 <= column < away.shape[1] and away[row, column] < 0):
        down, right = 0.97 * down, 0.97 * right
        row, column = int(np.rint(middle[0] + down)), int(np.rint(middle[1] + right))
    return row, column
