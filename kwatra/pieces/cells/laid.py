"""Where copies of cells lie in an output, told from the places that it shows."""

from typing import NamedTuple

import numpy as np

from kwatra.pieces.cells.shapes import Cells
from kwatra.pieces.seams import Array

MOST, LONGEST = 2.0, 4.0
"""What seems to be so many times as large or as small as it was is only moved: it tells too little; so is what would be
drawn so many times as long or as short along a line, as half of a turn by 180 degrees is nothing. Not tuned."""

LEAST = 1e-3
"""px^2 by which no direction is told. Not tuned."""


class Laid(NamedTuple):
    """Where copies of cells lie in an output.

    cell (m,): the numbers. to (m, 2, 3): what takes a pixel (row, column, 1) to its place on the exemplar's canvas.
    corner (m, 2), size (m, 2): the part of the output, or beyond it, that a cell's window covers, px. push (m,): by how
    many px it comes before others where it meets them.
    """

    cell: Array
    to: Array
    corner: Array
    size: Array
    push: Array


def moved(places: Array, copy: Array, count: int) -> Array:
    """What takes pixels to places (2, H, W) by whole pixels, as most do of each copy (m, 2, 3), numbered (H, W)."""
    some, to = copy >= 0, np.tile(np.eye(2, 3), (count, 1, 1))
    offsets = (places - np.indices(copy.shape))[:, some]
    to[:, :, 2] = np.rint(_means(copy[some], offsets, count))
    return to


def turned(places: Array, copy: Array, count: int, undone: float) -> Array:
    """What takes pixels to places (2, H, W) by least squares over each copy (m, 2, 3), numbered (H, W).

    What they are turned and stretched by is `undone` by that part of it.
    """
    some, to = copy >= 0, np.tile(np.eye(2, 3), (count, 1, 1))
    copy, pixels, places = copy[some], np.indices(copy.shape)[:, some].astype(float), places[:, some]
    middle, there = _means(copy, pixels, count), _means(copy, places, count)
    across, away = pixels - middle.T[:, copy], places - there.T[:, copy]
    spread, shared = (
        _means(copy, (one[:, None] * across).reshape(4, -1), count).reshape(-1, 2, 2) for one in (across, away)
    )
    linear = shared @ np.linalg.inv(spread + LEAST * np.eye(2))
    less = linear + undone * (np.eye(2) - linear)
    larger, longer = np.abs(np.linalg.det(linear)), np.linalg.svd(less, compute_uv=False)
    odd = (larger > MOST) | (larger < 1 / MOST) | (longer.max(1) > LONGEST) | (longer.min(1) < 1 / LONGEST)
    to[:, :, :2] = np.where(odd[:, None, None], np.eye(2), less)
    to[:, :, 2] = there - np.einsum("mij,mj->mi", to[:, :, :2], middle)
    return to


def _means(copy: Array, values: Array, count: int) -> Array:
    """The means (m, k) of values (k, N) over copies, numbered (N,)."""
    pixels = np.maximum(np.bincount(copy, minlength=count), 1)
    return np.stack([np.bincount(copy, value, count) / pixels for value in values], 1)


def lying(cell: Array, to: Array, cells: Cells) -> Laid:
    """Copies of cells that lie so, with the parts of the output that their windows cover."""
    first, extent, back = cells.shapes.first[cell], cells.shapes.extent[cell], np.linalg.inv(to[:, :, :2])
    half = (extent - 1) / 2
    middle = np.einsum("mij,mj->mi", back, first + half - to[:, :, 2])
    reach = np.einsum("mij,mj->mi", np.abs(back), half)
    corner = np.floor(middle - reach + 1e-6).astype(np.int64)
    size = np.ceil(middle + reach - 1e-6).astype(np.int64) - corner + 1
    return Laid(cell, to, corner, size, np.zeros(len(cell)))
