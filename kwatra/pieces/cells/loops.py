"""Cells of an exemplar in an output, in compiled loops.

Windows of cells (n,) lie one after the other in flat arrays, as `Shapes.windows` says. Copies (m,) are of some cell
each, and lie in an output as `Laid` says. Both are plain tuples here: numba keeps what it compiles with the names of
classes, and could not read it again once one had another.

This module is compiled by numba when first used, so it is imported where cells are fitted.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted

BEYOND = 1e3
"""px that what lies beyond a cell's window is away from it."""


@jitted
def window(windows: Any, values: Any, cell: Any) -> Any:
    """A cell's window (h, w) of values (N,)."""
    _, extent, start = windows
    height, width = extent[cell]
    return values[start[cell] : start[cell] + height * width].reshape((height, width))


@jitted
def seen(windows: Any, values: Any, laid: Any, m: Any, beyond: Any) -> Any:
    """What a copy's part of an output (h, w) sees of values (N,), bilinear; `beyond` where its window ends."""
    cell, to, corner, size = laid[0][m], laid[1][m], laid[2][m], laid[3][m]
    there, first = window(windows, values, cell), windows[0][cell]
    found = np.full((size[0], size[1]), np.float32(beyond))
    for i in range(found.shape[0]):
        for j in range(found.shape[1]):
            y, x = i + corner[0], j + corner[1]
            row = to[0, 0] * y + to[0, 1] * x + to[0, 2] - first[0]
            column = to[1, 0] * y + to[1, 1] * x + to[1, 2] - first[1]
            if 0 <= row <= there.shape[0] - 1 and 0 <= column <= there.shape[1] - 1:
                found[i, j] = between(there, row, column)
    return found


@jitted
def between(values: Any, row: Any, column: Any) -> Any:
    """Values (h, w) between pixels, bilinear."""
    i, j = min(int(row), values.shape[0] - 2), min(int(column), values.shape[1] - 2)
    down, right = row - i, column - j
    upper = values[i, j] * (1 - right) + values[i, j + 1] * right
    return upper * (1 - down) + (values[i + 1, j] * (1 - right) + values[i + 1, j + 1] * right) * down


@jitted
def count_inside(windows: Any, away: Any, element: Any, laid: Any, known: Any, counts: Any) -> None:
    """Count the pixels (m, 3) of copies' cells, of these where an output is known (H, W), and of elements there."""
    for m in range(len(counts)):
        far, of_element = seen(windows, away, laid, m, BEYOND), seen(windows, element, laid, m, 0.0)
        top, left = laid[2][m]
        for i in range(far.shape[0]):
            for j in range(far.shape[1]):
                counts[m, 0] += far[i, j] < 0
                y, x = i + top, j + left
                if 0 <= y < known.shape[0] and 0 <= x < known.shape[1] and known[y, x]:
                    counts[m, 1] += far[i, j] < 0
                    counts[m, 2] += of_element[i, j] > 0.5


@jitted
def divide(windows: Any, away: Any, laid: Any, best: Any, second: Any, owner: Any) -> None:
    """Set which copy is nearest to each pixel, `owner` (H, W), -1 where none is, how near, and how near the second is.

    away (N,): how far from cells each pixel of their windows is, px, below 0 inside.
    """
    best[:], second[:], owner[:] = np.inf, np.inf, -1
    for m in range(len(laid[0])):
        far, (top, left), push = seen(windows, away, laid, m, BEYOND), laid[2][m], laid[4][m]
        for i in range(max(-top, 0), min(far.shape[0], best.shape[0] - top)):
            for j in range(max(-left, 0), min(far.shape[1], best.shape[1] - left)):
                y, x = i + top, j + left
                if far[i, j] == np.float32(BEYOND):
                    continue
                near = far[i, j] - push
                if near < best[y, x]:
                    second[y, x], best[y, x], owner[y, x] = best[y, x], near, m
                elif near < second[y, x]:
                    second[y, x] = near


@jitted
def move(windows: Any, element: Any, laid: Any, reach: Any, astray: Any, owner: Any) -> None:
    """Move the copies that are astray (m,) to where most of their elements lies in their share, `owner` (H, W).

    reach: by so many pixels at most, along each axis; of equal places to the nearest.
    """
    for m in range(len(astray)):
        if not astray[m]:
            continue
        here, to, (top, left) = seen(windows, element, laid, m, 0.0), laid[1][m], laid[2][m]
        own, runs = _own_before(here.shape, top, left, reach, m, owner), _runs(here)
        most, nearest, best = -1, 0, (0, 0)
        for down in range(-reach, reach + 1):
            for right in range(-reach, reach + 1):
                far, count = down * down + right * right, _count_own(runs, own, down + reach, right + reach)
                if count > most or (count == most and far < nearest):
                    most, nearest, best = count, far, (down, right)
        for axis in range(2):
            laid[2][m, axis] += best[axis]
            to[axis, 2] -= to[axis, 0] * best[0] + to[axis, 1] * best[1]


@jitted
def _own_before(size: Any, top: Any, left: Any, reach: Any, m: Any, owner: Any) -> Any:
    """In the lines of a window (h, w) at (top, left), and so far around it, how many pixels are own before each.

    Own are a copy's, `owner` (H, W), and those beyond the output: (h + 2 reach, w + 2 reach + 1).
    """
    before = np.zeros((size[0] + 2 * reach, size[1] + 2 * reach + 1), np.int64)
    for i in range(before.shape[0]):
        y = top + i - reach
        for j in range(before.shape[1] - 1):
            x = left + j - reach
            beyond = not (0 <= y < owner.shape[0] and 0 <= x < owner.shape[1])
            before[i, j + 1] = before[i, j] + (beyond or owner[y, x] == m)
    return before


@jitted
def _runs(element: Any) -> Any:
    """The runs (n, 3) of an element's pixels (h, w): in which line, which is the first, and which follows the last."""
    found, count = np.empty((element.size // 2 + element.shape[0], 3), np.int64), 0
    for i in range(element.shape[0]):
        inside = False
        for j in range(element.shape[1] + 1):
            there = j < element.shape[1] and element[i, j] > 0.5
            if there and not inside:
                found[count, 0], found[count, 1] = i, j
            elif inside and not there:
                found[count, 2] = j
                count += 1
            inside = there
    return found[:count]


@jitted
def count_own(windows: Any, element: Any, laid: Any, owner: Any, shares: Any) -> None:
    """Set the share of each copy's element (m,) that is its own where it lies, `owner` (H, W), or beyond the output."""
    for m in range(len(shares)):
        there, (top, left) = seen(windows, element, laid, m, 0.0), laid[2][m]
        own = _own_before(there.shape, top, left, 0, m, owner)
        shares[m] = _count_own(_runs(there), own, 0, 0) / max((there > 0.5).sum(), 1)


@jitted
def _count_own(runs: Any, own: Any, down: Any, right: Any) -> Any:
    """How many pixels of an element, in `runs`, are own so far down and right, of lines with `own` before each."""
    count = 0
    for row, first, last in runs:
        count += own[row + down, last + right] - own[row + down, first + right]
    return count
