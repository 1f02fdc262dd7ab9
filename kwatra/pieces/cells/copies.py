"""Copies of an exemplar's cells in an output: which of them are wanted, however little is seen of them."""

from typing import NamedTuple

import numpy as np

from kwatra.base import joined
from kwatra.pieces.cells.laid import Laid, lying, moved, turned
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

UNDONE, UNDONE_LOOSE = 0.3, 0.5
"""So much of what elements that flow are turned and stretched by is undone in every frame, the second of those that are
loose. Of stones of 20 and 50 px in a pair of vortices, 60 frames, motion is off by .14 .35 px with .1, by .13 .37 with
the first, by .14 .43 with 1. Of coins of 20 and 32 px it is off by .22 .33 with both and .21 .33 with .6; by eye, with
the first some become ovals."""

MORE = 0.1
"""Another element stands in for one that the exemplar's border cuts where so much more of it is seen at least; it may
differ by as much in form. Not tuned."""

PUSH, LARGE = 0.5, 4.0
"""What flows and is seen smaller than it is comes so many times the radii that it lacks before others, and what is seen
larger after them, as if it were no more than so many times as large. Of stones, coins, tiles and mosaics of 20 and 32
px in a pair of vortices .19 are swollen or cut at frame 150 with none, .12 with .25, .08 with this and .09 with .7;
with 2 elements jump."""


class Copies(NamedTuple):
    """Copies of an exemplar's cells in an output that are wanted.

    laid: where they lie. shown, room (m,): how many pixels of each cell are seen, and the output has room for; elements
    (m,): the same of its element. number (H, W): of which copy each pixel is, -1 of none of them. stays (H, W): what is
    of cells that are not sure, and stays as it is; of loose ones no small part that the exemplar's border leaves.
    """

    laid: Laid
    shown: Array
    room: Array
    elements: Array
    number: Array
    stays: Array

    def without(self, some: Array) -> "Copies":
        """The others than some (m,) of them."""
        left = ~some
        number = np.append(np.where(left, np.cumsum(left) - 1, -1), -1)[self.number]
        laid = Laid(*(part[left] for part in self.laid))
        return Copies(laid, self.shown[left], self.room[left], self.elements[left], number, self.stays)


class _Region(NamedTuple):
    """Copies as they are found: number (H, W), -1 of none; of each its cell and how many pixels are shown (m,)."""

    number: Array
    cell: Array
    shown: Array


def copies_of(where: Array, cells: Cells) -> Copies:
    """The copies of cells of which enough is seen in a source map (2, H, W).

    Small parts that the exemplar's border leaves of loose elements do not stay; what is larger is several that touch.
    """
    everywhere = np.ones(where.shape[1:], bool)
    found, stay = _found(where, everywhere, cells), cells.whole | (cells.area > cells.usual)
    return _wanted(found, moved(where, found.number, len(found.cell)), everywhere, cells, SEEN, stay)


def copies_that_flow(places: Array, inside: Array, cells: Cells) -> Copies:
    """The same where places (2, H, W) between pixels are shown, inside (H, W), to which they were turned and stretched.

    A part of that is undone, and what is short of room pushes the others. Of loose elements nothing stays that the
    exemplar's border cuts: it would be drawn out. Of nine textures in a pair of vortices, 120 frames, .003 of elements
    are cut, .018 if several stay that touch; motion is off by .22 and .21 px.
    """
    found = _found(places, inside, cells)
    telling = _of_elements(found, places, cells) if cells.loose else found.number
    to = turned(places, telling, len(found.cell), UNDONE_LOOSE if cells.loose else UNDONE)
    copies = _wanted(found, to, inside, cells, LEFT, cells.whole)
    return copies._replace(laid=copies.laid._replace(push=_push(copies, _usual(cells)[copies.laid.cell])))


def _of_elements(found: _Region, places: Array, cells: Cells) -> Array:
    """The same numbers (H, W) where places (2, H, W) are of elements alone, of copies of which that is no crumb.

    The ground around loose ones is left as it flows, which would turn and stretch them more.
    """
    own = cells.shows_element(places) & (found.number >= 0)
    enough = np.bincount(found.number[own], minlength=len(found.cell)) > CRUMB * cells.usual
    return np.where((found.number >= 0) & (own | ~enough[found.number]), found.number, -1)


def _found(places: Array, known: Array, cells: Cells) -> _Region:
    """The copies of cells that are more than crumbs where an output shows places (2, H, W), as far as it is known."""
    number = np.where(known, cells.number[cells.at(places)], 0)
    count, copy = joined(*(_continued(number, places, axis) for axis in range(2)))
    shown, cell = np.bincount(copy.ravel(), minlength=count), number.ravel()[np.unique(copy, return_index=True)[1]]
    enough = (cell > 0) & (shown > CRUMB * cells.usual)
    return _Region(np.where(enough, np.cumsum(enough) - 1, -1)[copy], cell[enough], shown[enough])


def _wanted(found: _Region, to: Array, known: Array, cells: Cells, least: float, stay: Array) -> Copies:
    """Those of the copies, lying so, `to` (m, 2, 3), of which at least such a part is seen where it is known (H, W).

    stay (n,): of cells that are loose and not sure those that stay as they are.
    """
    laid, counts = _drawn(found.cell, to, cells, known)
    ends = np.array(known.shape) - 1
    beside = ((laid.corner + cells.reach <= 1) | (laid.corner + laid.size - cells.reach >= ends)).any(1)
    hidden = beside | (counts[:, 1] < counts[:, 0])  # nobody sees how an element goes on there, or whether it does
    room = np.where(hidden, counts[:, 1], _usual(cells)[laid.cell])
    seen, sure = found.shown >= least * room, cells.sure[laid.cell]
    stay = stay[laid.cell] | (not cells.loose)
    wanted, stays = seen & sure, np.append(seen & ~sure & stay, False)
    every = Copies(laid, found.shown, room, counts[:, 2], found.number, stays[found.number])
    return every.without(~wanted)


def _usual(cells: Cells) -> Array:
    """How large cells (n,) are, px^2, of those that are cut at least as usual."""
    return np.maximum(cells.area, np.where(cells.whole, 0, cells.usual))


def _drawn(cell: Array, to: Array, cells: Cells, known: Array) -> tuple[Laid, Array]:
    """Which cells are drawn, and where, for cells (m,) that lie so, `to` (m, 2, 3), and their counts (m, 3).

    Another stands in for one of which the output would show more than there is. Counted are the pixels of a cell, of
    these where an output is known (H, W), and of its element there.
    """
    laid, counts = _counted(cell, to, cells, known)
    cut = np.flatnonzero(cells.instead[cell] != cell)
    moved_on = np.concatenate([to[cut, :, :2], to[cut, :, 2:] + cells.further[cell[cut]][:, :, None]], 2)
    shown, more = _counted(cells.instead[cell[cut]], moved_on, cells, known)
    shows = more[:, 2] > (1 + MORE) * counts[cut, 2]
    for drawn, other in zip((*laid, counts), (*shown, more), strict=True):
        drawn[cut[shows]] = other[shows]
    return laid, counts


def _counted(cell: Array, to: Array, cells: Cells, known: Array) -> tuple[Laid, Array]:
    """Where copies of cells lie, and their counts (m, 3), as of `_drawn`."""
    from kwatra.pieces.cells.loops import count_inside

    laid, counts, shapes = lying(cell.copy(), to.copy(), cells), np.zeros((len(cell), 3), np.int64), cells.shapes
    count_inside(shapes.windows, shapes.away, shapes.element, tuple(laid), known, counts)
    return laid, counts


def _continued(number: Array, places: Array, axis: int) -> Array:
    """Whether pixels along an axis show places (2, H, W) of one cell, number (H, W), that continue each other."""
    steps = np.diff(places, axis=axis + 1) - (np.arange(2) == axis)[:, None, None]
    near: Array = (np.diff(number, axis=axis) == 0) & (np.abs(steps) <= APART).all(0)
    return near


def _push(copies: Copies, usual: Array) -> Array:
    """By how many px cells (m,), of usual sizes, px^2, come before others that lack less of the room that they need."""
    lacks = 1 - np.sqrt(np.minimum(copies.shown / np.maximum(copies.room, 1), LARGE))
    pushes: Array = PUSH * lacks * np.sqrt(usual / np.pi)
    return pushes
