"""The cells of an exemplar: each an element, and the ground that is nearer to it than to any other."""

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar
from kwatra.pieces.cells.rims import plain_ground, tips, with_rims
from kwatra.pieces.cells.standins import stand_ins
from kwatra.pieces.seams import Array, Parts, hidden_seams, parts_of

RAYS = 2 * math.pi
"""Cells are looked at, and warped, along so many rays for each pixel of an element's size: every half pixel of its
outline."""

COMPACT, LARGEST, ROUND, SURE = 0.9, 1.6, 0.985, 0.85
"""A cell is sure if so much of its element is seen from its middle, and it is no more times as large as usual: what is
larger is two that were not told apart, but for loose ones of which ROUND is seen, which are of many sizes. There are
cells if so much of what is whole is sure.

Of stones, mosaics, coins and tiles made in code .95 and more is, of chain mail .89, of nuts .57 and .75, of fabric .73,
of letters .66 and less, of print .24 (45 exemplars); of discs and buttons of several sizes all."""

FEW, SMALL = 3, 10.0
"""Fewer whole elements than this say nothing of their size, and smaller ones, px, are too coarse to be warped: of 12 px
stones come out well, chain mail of 7 px scores .067 in place of .060."""

NARROW, WIDE = 2.0, 0.75
"""Gaps are narrow with their median width, or with so many pixels on each side if that is more, and wide from this
quantile of their widths on; by eye, on made stones and coins: with .9 joints of stones become too wide."""

CUT = 0.3
"""A cell that is smaller, as a part of a usual one, needs no other in its place: it is never wanted."""

LEAST, TOUCHING = 0.05, 1.0
"""Gaps of loose elements are narrow with this quantile of their widths, or with so many pixels if that is more: they
rather come near each other than lose their form. Not tuned."""

AROUND = 0.5
"""Cells are stretched by so much of an element's size at most; further away from all of them output stays as it is."""

SOFT = 0.06
"""Borders between warped cells are smooth over so much of an element's size, as outlines that meet do not match. By
eye."""


class Shapes(NamedTuple):
    """Windows around cells (n,), numbered from 1; that of 0 is empty.

    first (n, 2): the place on the exemplar's canvas of a window's first pixel; extent (n, 2): its size. What follows is
    of all their pixels, from `start` (n,) on each. away (N,): px from the cell's border, below 0 inside; soft (N,): the
    same, smoothed; element (N,): whether a pixel is of the cell's element.
    """

    first: Array
    extent: Array
    start: Array
    away: Array
    soft: Array
    element: Array

    @property
    def windows(self) -> tuple[Array, Array, Array]:
        """Where windows lie on the canvas, how large they are, and where each begins among values of all."""
        return self.first, self.extent, self.start


class Cells(NamedTuple):
    """The cells of an exemplar's canvas.

    number (*S): of the cell each place belongs to, from 1; 0 of nobody's. element (*S): whether it is of an element, or
    of what the border leaves of one, which is nobody's.
    area (n,): of each, px; whole (n,): whether nothing cuts its element; sure (n,): whether it is one element that can
    be warped along rays. usual: the area of a usual whole one. gaps: how wide the ground beside an element is, px,
    where it is narrow and where it is wide; infinite where elements are loose. reach: how far windows go beyond cells,
    px. rays: along how many each is warped. instead (n,): the cell that is drawn for each where it would show what
    nobody knows (`standins`), and how much further on the canvas the places of that one are: further (n, 2).
    """

    number: Array
    element: Array
    area: Array
    whole: Array
    sure: Array
    usual: float
    gaps: tuple[float, float]
    reach: int
    rays: int
    shapes: Shapes
    instead: Array
    further: Array

    @property
    def loose(self) -> bool:
        """Whether elements lie on wide and plain ground, and need not fill the room that they have."""
        return math.isinf(self.gaps[1])

    def at(self, places: Array) -> tuple[Array, ...]:
        """The index of the pixels of the canvas next to places (2, H, W) between them."""
        last = np.array(self.number.shape)[:, None, None] - 1
        return tuple(np.rint(places).astype(np.int64).clip(0, last))

    def shows_element(self, places: Array) -> Array:
        """Where (H, W) places (2, H, W) between pixels are of an element, or of what the border leaves of one."""
        return self.element[self.at(places)]

    @property
    def ground(self) -> Array:
        """Where on the canvas (*S) there is ground, and no blurred rim of an element."""
        return (self.number > 0) & ~ndimage.binary_dilation(self.element)


class _Elements(NamedTuple):
    """The elements of an exemplar's canvas, which there is `inside` (*S), between gaps that hide seams.

    nobodys (*S): what the border leaves of some; loose: whether they lie on wide and plain ground. colors (C, *S).
    """

    parts: Parts
    inside: Array
    nobodys: Array
    loose: bool
    colors: Array

    def cells(self, parts: Parts) -> Cells | None:
        """The cells around parts, those of elements or what stands for them."""
        cells = cells_of(parts, self.inside & ~self.nobodys, self.loose)
        if cells is None:
            return None
        cells = cells._replace(element=cells.element | self.nobodys)
        cut, whole = ~cells.whole & (cells.area > CUT * cells.usual), cells.whole & cells.sure
        instead, further = stand_ins(cells.number, cells.element, self.colors, cut, whole)
        return cells._replace(instead=instead, further=further)


@kept
def find_cells(exemplar: Exemplar) -> Cells | None:
    """The cells of an exemplar of still images; None without compact elements, apart by gaps that hide seams.

    Nor of bricks: moved to meet, those made in code flow off by .5 px, not .2, as they lose their straight sides.

    Memory is that of three arrays of single precision for each cell's window, on top of some of the canvas's size.
    """
    found = _elements(exemplar)
    return None if found is None else found.cells(found.parts)


@kept
def cells_that_flow(exemplar: Exemplar) -> Cells | None:
    """As `find_cells`; where there are none those around the hulls of loose elements with bays (`hulls`), as letters.

    Ground further from them than AROUND is no cell's. Of letters of 20 and 32 px .05 are cut at frame 150 of a rotation
    and of a pair of vortices, .18 without. In stills hulls serve nobody: .004 are cut, and print that is laid
    with them, so that its letters leave their rows, scores .069 in place of .042.
    """
    cells = find_cells(exemplar)
    found = _elements(exemplar) if cells is None else None
    if found is None or not found.loose:
        return cells
    from kwatra.pieces.cells.hulls import hulls

    parts = hulls(found.parts, found.inside)
    if parts is None:
        return None
    away = ndimage.distance_transform_edt(parts.number <= 0)
    return found._replace(inside=found.inside & (away <= AROUND * parts.size)).cells(parts)


def _elements(exemplar: Exemplar) -> _Elements | None:
    """The elements of an exemplar; None where no gaps hide seams, and of bricks."""
    hidden = hidden_seams(exemplar)
    if hidden is None or hidden.parts is not None or hidden.long:
        return None
    inside, colors = (exemplar.owner >= 0).cpu().numpy(), exemplar.canvas.cpu().numpy()
    parts = parts_of(hidden, inside)
    plain, nobodys = plain_ground(parts.number, inside), np.zeros(inside.shape, bool)
    if plain is not None:
        parts = with_rims(parts, colors, inside, plain)
        nobodys = tips(parts.number, colors, inside, plain)
    return _Elements(parts, inside, nobodys, plain is not None, colors)


def cells_of(parts: Parts, inside: Array, loose: bool = False) -> Cells | None:
    """The cells around some parts, of what is `inside` (*S) of a canvas; None if the parts are few or not compact.

    loose: whether they lie on wide ground.
    """
    from kwatra.pieces.cells.rays import seen_from_middle

    element, whole = parts.number > 0, parts.whole(inside)
    if np.count_nonzero(whole) < FEW or parts.size < SMALL:
        return None
    number = np.where(inside, parts.nearest, 0)
    area = np.bincount(number.ravel(), minlength=len(whole))
    reach = max(round(AROUND * parts.size), 2)
    shapes, rays = _shapes(number, element, reach), round(RAYS * reach / AROUND)
    seen, gaps = np.empty(len(whole)), np.empty((len(whole), rays))
    seen_from_middle(shapes.windows, shapes.away, shapes.element, rays, seen, gaps)
    usual = float(np.median(area[whole]))
    sure = (seen >= COMPACT) & ((area <= LARGEST * usual) | (loose & (seen >= ROUND)))
    if area[whole & sure].sum() < SURE * area[whole].sum():
        return None
    least, narrow, wide = np.quantile(gaps[whole & sure], (LEAST, 0.5, WIDE)).tolist()
    ground = (min(least, TOUCHING), math.inf) if loose else (min(narrow, NARROW), wide)
    themselves = np.arange(len(whole))
    unmoved = np.zeros((len(whole), 2), np.int64)
    return Cells(number, element, area, whole, sure, usual, ground, reach, rays, shapes, themselves, unmoved)


def _shapes(number: Array, element: Array, reach: int) -> Shapes:
    """The windows of cells (*S), by number, which go so far beyond them."""
    firsts, windows = [(0, 0)], [np.empty((3, 0, 0), np.float32)]
    for cell, box in enumerate(ndimage.find_objects(number), 1):
        own = np.pad(number[box] == cell, reach)
        beyond, within = ndimage.distance_transform_edt(~own), ndimage.distance_transform_edt(own)
        away = np.where(own, 0.5 - within, beyond - 0.5)
        soft = ndimage.gaussian_filter(away, SOFT * reach / AROUND)
        firsts.append((box[0].start - reach, box[1].start - reach))
        windows.append(np.stack([away, soft, own & np.pad(element[box], reach)]).astype(np.float32))
    extent = np.array([window.shape[1:] for window in windows])
    away, soft, elements = (np.concatenate([window[k].ravel() for window in windows]) for k in range(3))
    return Shapes(np.array(firsts), extent, np.cumsum(extent.prod(1)) - extent.prod(1), away, soft, elements > 0)
