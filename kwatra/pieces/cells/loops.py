"""Cells of an exemplar in an output, in compiled loops.

Windows of cells (n,) lie one after the other in flat arrays (`Shapes`). Copies (m,) are of some cell each, their
windows begin at `first` (m, 2), which may be beyond the output. Pixels, rows and columns are those of an output.

This module is compiled by numba when first used, so it is imported where cells are fitted.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def join(number: Any, where: Any, apart: Any, copy: Any) -> Any:
    """Set of which copy each pixel is (H, W), counted from 0 by their first pixels; returns how many there are.

    Pixels beside each other are of one if their places (2, H, W) are of one cell, number (H, W), and continue each
    other but for `apart` pixels.
    """
    height, width = number.shape
    root = np.arange(height * width)
    for i in range(height):
        for j in range(width):
            for down, right in ((0, 1), (1, 0)):
                y, x = i + down, j + right
                if y < height and x < width and number[i, j] == number[y, x]:
                    rows, columns = where[0, y, x] - where[0, i, j] - down, where[1, y, x] - where[1, i, j] - right
                    if abs(rows) <= apart and abs(columns) <= apart:
                        one, other = _root(root, i * width + j), _root(root, y * width + x)
                        root[max(one, other)] = min(one, other)
    count = 0
    for i in range(height):
        for j in range(width):
            first = _root(root, i * width + j)
            if first == i * width + j:
                copy[i, j] = count
                count += 1
            else:
                copy[i, j] = copy[first // width, first % width]
    return count


@jitted
def _root(root: Any, pixel: Any) -> Any:
    while root[pixel] != pixel:
        root[pixel] = root[root[pixel]]
        pixel = root[pixel]
    return pixel


@jitted
def window(shapes: Any, values: Any, cell: Any) -> Any:
    """A cell's window (h, w) of values (N,)."""
    height, width = shapes.extent[cell]
    return values[shapes.start[cell] : shapes.start[cell] + height * width].reshape((height, width))


@jitted
def count_inside(shapes: Any, cell: Any, first: Any, shape: Any, inside: Any) -> None:
    """Count the pixels inside (m, 2) of copies' cells, and of their elements, that are in an output of a shape."""
    for m in range(len(cell)):
        away, element = window(shapes, shapes.away, cell[m]), window(shapes, shapes.element, cell[m])
        for i in range(max(-first[m, 0], 0), min(away.shape[0], shape[0] - first[m, 0])):
            for j in range(max(-first[m, 1], 0), min(away.shape[1], shape[1] - first[m, 1])):
                inside[m, 0] += away[i, j] < 0
                inside[m, 1] += element[i, j]


@jitted
def divide(shapes: Any, aways: Any, cell: Any, first: Any, best: Any, second: Any, owner: Any) -> None:
    """Set which copy is nearest to each pixel, `owner` (H, W), -1 where none is, how near, and how near the second is.

    aways (N,): how far from cells each pixel of their windows is, px, below 0 inside.
    """
    best[:], second[:], owner[:] = np.inf, np.inf, -1
    for m in range(len(cell)):
        away = window(shapes, aways, cell[m])
        for i in range(max(-first[m, 0], 0), min(away.shape[0], best.shape[0] - first[m, 0])):
            y = i + first[m, 0]
            for j in range(max(-first[m, 1], 0), min(away.shape[1], best.shape[1] - first[m, 1])):
                x = j + first[m, 1]
                if away[i, j] < best[y, x]:
                    second[y, x], best[y, x], owner[y, x] = best[y, x], away[i, j], m
                elif away[i, j] < second[y, x]:
                    second[y, x] = away[i, j]


@jitted
def move(shapes: Any, cell: Any, first: Any, margin: Any, reach: Any, loose: Any, owner: Any) -> None:
    """Move the copies that are loose (m,) to where most of their elements lies in their share, `owner` (H, W).

    margin: of windows around cells. reach: by so many pixels at most, along each axis; of equal places to the nearest.
    """
    for m in range(len(cell)):
        if not loose[m]:
            continue
        element = window(shapes, shapes.element, cell[m])[margin:-margin, margin:-margin]
        most, nearest, best = -1, 0, (0, 0)
        for down in range(-reach, reach + 1):
            for right in range(-reach, reach + 1):
                far = down * down + right * right
                count = _count_own(element, first[m, 0] + margin + down, first[m, 1] + margin + right, m, owner)
                if count > most or (count == most and far < nearest):
                    most, nearest, best = count, far, (down, right)
        first[m, 0] += best[0]
        first[m, 1] += best[1]


@jitted
def _count_own(element: Any, top: Any, left: Any, m: Any, owner: Any) -> Any:
    """How many pixels of an element (h, w) whose first is at (top, left) are a copy's own, or beyond the output."""
    count = 0
    for i in range(element.shape[0]):
        for j in range(element.shape[1]):
            if element[i, j]:
                y, x = top + i, left + j
                count += not (0 <= y < owner.shape[0] and 0 <= x < owner.shape[1]) or owner[y, x] == m
    return count
