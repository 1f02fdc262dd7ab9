"""Elements made whole: cells of copies that overlap, or leave room between them, are warped until they meet.

Copies of a texture whose elements fill the plane seldom meet along gaps of both: seams cut elements, and slivers of
others are left. So cells are taken whole from what is laid. Of each of which enough is seen all is wanted, where it was
laid; the plane is divided among these, each pixel going to the cell that it is deepest in, or nearest to. An element
that has its place stays as it is. Another moves to where most of it lies in its share, and its cell is warped along
rays from its middle until it fills that share, gaps and all (compare Wu and Yu 2004, "Feature matching and deformation
for texture synthesis", where patches are warped until their features meet).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.pieces.cells.shapes import RAYS, Cells
from kwatra.pieces.seams import Array

APART = 2
"""Copies of an element that are apart by so many pixels at most, and touch, are one. Not tuned."""

SEEN, CRUMB = 0.45, 0.02
"""An element is wanted if so much of its cell is seen as would be in the output, and the second part of a usual one."""

MISSED = 0.01
"""An element has its place if no more of it, or of its area of others, is where it should not be. Not tuned."""

MOVED = 1 / 6
"""Elements move by so much of their size at most, along each axis."""

RIM = 2
"""So many pixels of ground stay around an element that stays. Not tuned."""

STRETCHED = 1.5
"""Elements are stretched and squeezed by no more where that is enough, and keep their size around the middle."""

AROUND = 4
"""An output that wraps is looked at with so many elements around it: further than what one does to the next."""


class Copies(NamedTuple):
    """Copies of an exemplar's cells in an output that are wanted.

    cell (m,): its number; first (m, 2): where its window begins in the output, px. number (H, W): of which copy each
    pixel is, -1 of none of them. stays (H, W): what is of cells that are not sure, and stays as it is.
    """

    cell: Array
    first: Array
    number: Array
    stays: Array


def fitted(where: Tensor, cells: Cells, wraps: Sequence[bool] = (False, False)) -> Tensor:
    """A source map (2, H, W) with the elements of copies made whole; wraps: along which axes it is periodic.

    Memory is that of some eight arrays of the output's size.
    """
    around = [(AROUND * cells.reach * wrap,) * 2 for wrap in wraps]
    made = _fitted(np.pad(where.cpu().numpy(), [(0, 0), *around], mode="wrap"), cells)
    inner = tuple(slice(before, size - after) for (before, after), size in zip(around, made.shape[1:], strict=True))
    return torch.from_numpy(np.ascontiguousarray(made[(slice(None), *inner)])).to(where)


def _fitted(where: Array, cells: Cells) -> Array:
    from kwatra.pieces.cells.loops import divide, move
    from kwatra.pieces.cells.rays import warp

    copies, shape, shapes = copies_in(where, cells), where.shape[1:], cells.shapes
    best, second, share = np.empty(shape, np.float32), np.empty(shape, np.float32), np.empty(shape, np.int64)
    divide(shapes, shapes.away, copies.cell, copies.first, best, second, share)
    share[copies.stays] = -1
    loose, others = _loose(where, cells, copies, share)
    if not (loose.any() or others.any()):
        return where
    first = copies.first.copy()
    move(shapes, copies.cell, first, cells.reach, round(MOVED * cells.reach), loose, share)
    divide(shapes, shapes.soft, copies.cell, first, best, second, share)
    share[copies.stays] = -1
    kept = (copies.number >= 0) & ~loose[copies.number]
    kept &= ndimage.binary_dilation(kept & cells.element[tuple(where)], iterations=RIM)
    share[kept] = copies.number[kept]
    made, written = where.copy(), (share >= 0) & (loose[share] | (others & (copies.number != share)))
    warp(shapes, copies.cell, first, RAYS, STRETCHED, cells.gaps, best, second, share, written, made)
    return made


def copies_in(where: Array, cells: Cells) -> Copies:
    """The copies of cells of which enough is seen in a source map (2, H, W)."""
    from kwatra.pieces.cells.loops import count_inside, join

    shape, number = where.shape[1:], cells.number[tuple(where)]
    copy = np.empty(shape, np.int64)
    count = join(number, where, APART, copy)
    seen, offsets = np.bincount(copy.ravel(), minlength=count), np.indices(shape) - where
    cell = number.ravel()[np.unique(copy, return_index=True)[1]]
    summed = np.stack([np.bincount(copy.ravel(), offset.ravel()) for offset in offsets], 1)
    first = np.rint(summed / seen[:, None]).astype(np.int64) + cells.shapes.first[cell]
    inside = np.zeros((count, 2), np.int64)
    count_inside(cells.shapes, cell, first, np.array(shape), inside)
    start, stop = first + cells.reach, first + cells.shapes.extent[cell] - cells.reach
    beside = ((start <= 1) | (stop >= np.array(shape) - 1)).any(1)  # nobody sees there where the exemplar ends
    usual = np.where(cells.whole, 0, cells.usual)
    wanted = seen >= np.maximum(SEEN * np.where(beside, inside[:, 0], np.maximum(cells.area, usual)[cell]), 1)
    wanted &= (cell > 0) & (seen > CRUMB * cells.usual)
    stays, wanted = wanted & ~cells.sure[cell], wanted & cells.sure[cell]
    renumbered = np.where(wanted, np.cumsum(wanted) - 1, -1)
    return Copies(cell[wanted], first[wanted], renumbered[copy], stays[copy])


def _loose(where: Array, cells: Cells, copies: Copies, share: Array) -> tuple[Array, Array]:
    """Which copies (m,) do not have their place, and which pixels (H, W) are of elements that have none there.

    All of an element is to be in its share, and nothing of another.
    """
    from kwatra.pieces.cells.loops import count_inside

    count, inside = len(copies.cell), np.zeros((len(copies.cell), 2), np.int64)
    count_inside(cells.shapes, copies.cell, copies.first, np.array(share.shape), inside)
    element, own = cells.element[tuple(where)] & (share >= 0), copies.number == share
    others = element & ~own
    placed, found = (np.bincount(share[some], minlength=count) for some in (element & own, others))
    return (placed < (1 - MISSED) * inside[:, 1]) | (found > MISSED * inside[:, 1]), others
