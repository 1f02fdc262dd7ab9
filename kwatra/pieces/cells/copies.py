"""Copies of an exemplar's cells in an output: where they lie, however little is seen of them."""

from typing import NamedTuple

import numpy as np

from kwatra.base import joined
from kwatra.pieces.cells.shapes import Cells
from kwatra.pieces.seams import Array

APART = 2
"""Copies of an element that are apart by so many pixels at most, and touch, are one. Not tuned."""

SEEN, CRUMB = 0.45, 0.02
"""An element is wanted if so much of its cell is seen as would be in the output, and the second part of a usual one. By
eye, as STRETCHED (`fitting`), on stones, mosaics and coins of 12 to 50 pixels."""

LEFT = 0.3
"""The same of what flows, which gives way below it. Of stones and mosaics of 20 and 26 px and coins of 32 in a pair of
vortices .18 are cut or swollen at frame 150 with .45, .07 with this, .07 with .2 and with .15."""

MOST = 2.0
"""What seems to be so many times as large or as small as it was is only moved: it tells too little. Not tuned."""

UNDONE, UNDONE_LOOSE = 0.3, 0.5
"""So much of what elements that flow are turned and stretched by is undone in every frame, the second of those that are
loose. Of stones of 20 and 50 px in a pair of vortices, 60 frames, motion is off by .14 .35 px with .1, by .13 .37 with
the first, by .14 .43 with 1. Of coins of 20 and 32 px it is as far off with the first, the second and .6; by eye, with
the first some become ovals."""

MORE = 0.1
"""Another element stands in for one that the exemplar's border cuts where so much more of it is seen at least; it may
differ by as much in form. Not tuned."""

PUSH, LARGE = 0.5, 4.0
"""What flows and is seen smaller than it is comes so many times the radii that it lacks before others, and what is seen
larger after them, as if it were no more than so many times as large. Of stones, coins, tiles and mosaics of 20 and 32
px in a pair of vortices .19 are swollen or cut at frame 150 with none, .12 with .25, .08 with this and .09 with .7;
with 2 elements jump."""

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


class Copies(NamedTuple):
    """Copies of an exemplar's cells in an output that are wanted.

    laid: where they lie. elements (m,): how many pixels of each's element the output has room for. number (H, W): of
    which copy each pixel is, -1 of none of them. stays (H, W): what is of cells that are not sure, and stays as it is.
    """

    laid: Laid
    elements: Array
    number: Array
    stays: Array


def copies_in(places: Array, cells: Cells, inside: Array | None = None) -> Copies:
    """The copies of cells of which enough is seen where an output shows places (2, H, W).

    inside (H, W): where there is any, of places between pixels, to which copies may have been turned and stretched,
    a part of which is undone; None for a source map, of which all is copied.
    """
    shape, corner = places.shape[1:], np.array(cells.number.shape)[:, None, None] - 1
    number = cells.number[tuple(np.rint(places).astype(np.int64).clip(0, corner))]
    known = np.ones(shape, bool) if inside is None else inside
    number = np.where(known, number, 0)
    count, copy = joined(*(_continued(number, places, axis) for axis in range(2)))
    shown, cell = np.bincount(copy.ravel(), minlength=count), number.ravel()[np.unique(copy, return_index=True)[1]]
    enough = (cell > 0) & (shown > CRUMB * cells.usual)
    copy, shown, cell = np.where(enough, np.cumsum(enough) - 1, -1)[copy], shown[enough], cell[enough]
    to = (_moved if inside is None else _turned)(places, copy, len(cell), cells)
    cell, laid, counts = _seen(cell, to, cells, known)
    beside = ((laid.corner + cells.reach <= 1) | (laid.corner + laid.size - cells.reach >= np.array(shape) - 1)).any(1)
    hidden = beside | (counts[:, 1] < counts[:, 0])  # nobody sees how an element goes on there, or whether it does
    usual = np.maximum(cells.area, np.where(cells.whole, 0, cells.usual))[cell]
    room = np.where(hidden, counts[:, 1], usual)
    wanted = shown >= (SEEN if inside is None else LEFT) * room
    stays, wanted = wanted & ~cells.sure[cell], wanted & cells.sure[cell]
    renumbered = np.append(np.where(wanted, np.cumsum(wanted) - 1, -1), -1)
    if inside is not None:
        laid.push[:] = _push(shown, room, usual)
    laid = Laid(*(part[wanted] for part in laid))
    return Copies(laid, counts[wanted, 2], renumbered[copy], np.append(stays, False)[copy])


def _seen(cell: Array, to: Array, cells: Cells, known: Array) -> tuple[Array, Laid, Array]:
    """Which cells (m,) are drawn where `cell` (m,) lie so, `to` (m, 2, 3), where they lie, and their counts (m, 3).

    Another stands in for one of which the output would show more than there is. Counted are the pixels of a cell, of
    these where an output is known (H, W), and of its element there.
    """
    laid, counts = _counted(cell, to, cells, known)
    other = cells.instead[cell]
    if (other == cell).all():
        return cell, laid, counts
    moved = np.concatenate([to[:, :, :2], to[:, :, 2:] + cells.further[cell][:, :, None]], 2)
    shown, more = _counted(other, moved, cells, known)
    shows = more[:, 2] > (1 + MORE) * counts[:, 2]
    both = zip(laid, shown, strict=True)
    laid = Laid(*(np.where(shows.reshape(-1, *[1] * (one.ndim - 1)), two, one) for one, two in both))
    return laid.cell, laid, np.where(shows[:, None], more, counts)


def _counted(cell: Array, to: Array, cells: Cells, known: Array) -> tuple[Laid, Array]:
    """Where copies of cells lie, and their counts (m, 3), as of `_seen`."""
    from kwatra.pieces.cells.loops import count_inside

    laid, counts, shapes = _laid(cell, to, cells), np.zeros((len(cell), 3), np.int64), cells.shapes
    count_inside(shapes.windows, shapes.away, shapes.element, tuple(laid), known, counts)
    return laid, counts


def _continued(number: Array, places: Array, axis: int) -> Array:
    """Whether pixels along an axis show places (2, H, W) of one cell, number (H, W), that continue each other."""
    steps = np.diff(places, axis=axis + 1) - (np.arange(2) == axis)[:, None, None]
    near: Array = (np.diff(number, axis=axis) == 0) & (np.abs(steps) <= APART).all(0)
    return near


def _moved(places: Array, copy: Array, count: int, cells: Cells) -> Array:
    """What takes pixels to places (2, H, W) by whole pixels, as most do of each copy (m, 2, 3), numbered (H, W)."""
    some, to = copy >= 0, np.tile(np.eye(2, 3), (count, 1, 1))
    offsets = (places - np.indices(copy.shape))[:, some]
    to[:, :, 2] = np.rint(_means(copy[some], offsets, count))
    return to


def _turned(places: Array, copy: Array, count: int, cells: Cells) -> Array:
    """What takes pixels to places (2, H, W) by least squares over each copy (m, 2, 3), numbered (H, W).

    A part of what they are turned and stretched by is left out.
    """
    some, to = copy >= 0, np.tile(np.eye(2, 3), (count, 1, 1))
    copy, pixels, places = copy[some], np.indices(copy.shape)[:, some].astype(float), places[:, some]
    middle, there = _means(copy, pixels, count), _means(copy, places, count)
    across, away = pixels - middle.T[:, copy], places - there.T[:, copy]
    spread, shared = (
        _means(copy, (one[:, None] * across).reshape(4, -1), count).reshape(-1, 2, 2) for one in (across, away)
    )
    turned = shared @ np.linalg.inv(spread + LEAST * np.eye(2))
    larger = np.abs(np.linalg.det(turned))
    turned[(larger > MOST) | (larger < 1 / MOST)] = np.eye(2)
    to[:, :, :2] = turned + (UNDONE_LOOSE if cells.loose else UNDONE) * (np.eye(2) - turned)
    to[:, :, 2] = there - np.einsum("mij,mj->mi", to[:, :, :2], middle)
    return to


def _push(shown: Array, room: Array, usual: Array) -> Array:
    """By how many px cells (m,) come before others that have less of the room that they need, all in px^2."""
    return PUSH * (1 - np.sqrt(np.minimum(shown / np.maximum(room, 1), LARGE))) * np.sqrt(usual / np.pi)


def _means(copy: Array, values: Array, count: int) -> Array:
    """The means (m, k) of values (k, N) over copies, numbered (N,)."""
    pixels = np.maximum(np.bincount(copy, minlength=count), 1)
    return np.stack([np.bincount(copy, value, count) / pixels for value in values], 1)


def _laid(cell: Array, to: Array, cells: Cells) -> Laid:
    """Copies of cells that lie so, with the parts of the output that their windows cover."""
    first, extent, back = cells.shapes.first[cell], cells.shapes.extent[cell], np.linalg.inv(to[:, :, :2])
    half = (extent - 1) / 2
    middle = np.einsum("mij,mj->mi", back, first + half - to[:, :, 2])
    reach = np.einsum("mij,mj->mi", np.abs(back), half)
    corner = np.floor(middle - reach + 1e-6).astype(np.int64)
    size = np.ceil(middle + reach - 1e-6).astype(np.int64) - corner + 1
    return Laid(cell, to, corner, size, np.zeros(len(cell)))
