"""Elements made whole: cells of copies that overlap, or leave room between them, are warped until they meet.

Copies of a texture whose elements fill the plane seldom meet along gaps of both: seams cut elements, and slivers of
others are left. So cells are taken whole from what is laid. Of each of which enough is seen all is wanted, where it was
laid; the plane is divided among these, each pixel going to the cell that it is deepest in, or nearest to. An element
that has its place stays as it is. Another moves to where most of it lies in its share, and its cell is warped along
rays from its middle until it fills that share, gaps and all (compare Wu and Yu 2004, "Feature matching and deformation
for texture synthesis", where patches are warped until their features meet). Elements on wide and plain ground are
loose: they are squeezed where they lack room, or give way, but never stretched to fill it, and the ground stays as it
was laid.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.pieces.cells.clearing import cleared, seen_of
from kwatra.pieces.cells.copies import Copies, copies_of, copies_that_flow
from kwatra.pieces.cells.grain import Grain, grain_of
from kwatra.pieces.cells.shapes import Cells
from kwatra.pieces.seams import Array

MISSED = 0.01
"""An element has its place if no more of it, or of its area of others, is where it should not be. Not tuned."""

MOVES, MOVED = 4, 1 / 3
"""Elements move to where they have room by so much of what they are stretched by at most, along each axis; loose ones
so often. By eye: if they move once coins that met are dented, with 10 times no less than with 4. Three stills of stones
of 50 px that fill the plane score .068 if these move once, .078 with 4 times."""

ROOM = 0.7
"""A loose element gives way if less of it has room once it has moved; else it is squeezed. By eye, on coins."""

STRETCHED = 1.5
"""Elements are stretched and squeezed by no more where that is enough, and keep their size around the middle."""

AROUND = 8
"""An output that wraps is looked at with so many times as much around it as one element reaches the next."""


class Fitted(NamedTuple):
    """A source map with elements made whole: places (2, H, W), float64, between pixels where elements are warped.

    changed (H, W): where they are others than were laid. detail (2, H, W) int64, share (H, W): at which pixels detail
    is read, and how much of it (`grain`).
    """

    places: Tensor
    changed: Tensor
    detail: Tensor
    share: Tensor


def fitted(where: Tensor, cells: Cells, image: Array, wraps: Sequence[bool] = (False, False)) -> Fitted:
    """A source map (2, H, W) with the elements of copies made whole.

    image (C, *S): the colors of the exemplar's canvas. wraps: along which axes the map is periodic. Memory is that of
    some ten arrays of the output's size.
    """
    around = [(AROUND * cells.reach * wrap,) * 2 for wrap in wraps]
    made, grain = _fitted(np.pad(where.cpu().numpy(), [(0, 0), *around], mode="wrap"), cells, image)
    rows, columns = (slice(before, before + size) for (before, _), size in zip(around, where.shape[1:], strict=True))
    places, detail, share = (
        torch.from_numpy(np.ascontiguousarray(part[..., rows, columns])).to(where.device) for part in (made, *grain)
    )
    return Fitted(places, (places != where).any(0), detail, share)


class _Divided(NamedTuple):
    """Which copy each pixel (H, W) goes to, -1 where to none, how near that is, and how near the next."""

    share: Array
    best: Array
    second: Array


def _fitted(where: Array, cells: Cells, image: Array) -> tuple[Array, Grain]:
    """Places (2, H, W) with elements made whole, and where their detail is read."""
    copies, made = copies_of(where, cells), where.astype(np.float64)
    astray, others = np.zeros(len(copies.shown), bool), np.zeros(where.shape[1:], bool)
    while True:
        divided, astray, others = _moved(where, cells, copies, astray, others)
        if not (astray.any() or others.any()):
            return made, Grain.warped(made)
        if not (cells.loose and (crowded := _crowded(cells, copies, divided.share)).any()):
            break
        copies, astray = copies.without(crowded), astray[~crowded]
    share = divided.share
    kept = seen_of(where, (copies.number >= 0) & ~astray[copies.number], cells)
    share[kept] = copies.number[kept]
    written = (share >= 0) & (astray[share] | (others & (copies.number != share)))
    _warp(copies, cells, divided, written, made)
    if cells.loose:
        cleaner = cleared(where, made, written, kept | copies.stays, cells, image)
        return cleaner, Grain.warped(cleaner)
    return made, grain_of(made, share, written, cells)


def _moved(where: Array, cells: Cells, copies: Copies, astray: Array, others: Array) -> tuple[_Divided, Array, Array]:
    """How the plane is divided once copies that are astray have moved; and what was or then is, as of `_astray`."""
    from kwatra.pieces.cells.loops import move

    shapes, reach = cells.shapes, round(MOVED * cells.reach)
    divided = _divided(copies, cells, shapes.away)
    more = _astray(where, cells, copies, divided.share)
    astray, others = astray | more[0], others | more[1]
    if not (astray.any() or others.any()):
        return divided, astray, others
    for _ in range(MOVES if cells.loose else 1):
        move(shapes.windows, shapes.element, tuple(copies.laid), reach, astray, divided.share)
        divided = _divided(copies, cells, shapes.soft)
        if cells.loose:
            more = _astray(where, cells, copies, divided.share)
            astray, others = astray | more[0], others | more[1]
    return divided, astray, others


def _crowded(cells: Cells, copies: Copies, share: Array) -> Array:
    """Which copies (m,) lack room for their elements: of those beside each other the one that lacks most."""
    from kwatra.pieces.cells.loops import count_own

    found, laid = np.zeros(len(copies.laid.cell)), copies.laid
    count_own(cells.shapes.windows, cells.shapes.element, tuple(laid), share, found)
    crowded, last = np.zeros(len(found), bool), laid.corner + laid.size
    for m in np.argsort(found, kind="stable").tolist():
        if found[m] >= ROOM:
            break
        crowded[m] = not ((laid.corner[crowded] < last[m]) & (last[crowded] > laid.corner[m])).all(1).any()
    return crowded


def redrawn(places: Tensor, inside: Tensor, cells: Cells) -> Tensor:
    """Places (2, H, W) between pixels, where they are inside (H, W), with each copy's element drawn anew, and whole.

    An element is drawn as what is seen of it has been moved, turned and stretched on the mean, a part of which is
    undone (`copies.UNDONE`), and gives way where others come too near. As all are drawn so nothing jumps that moves a
    little. The ground around loose ones flows on, but where it would show more of them. Memory is as of `fitted`.
    """
    before, known = places.double().cpu().numpy(), inside.cpu().numpy()
    copies, made = copies_that_flow(before, known, cells), before.copy()
    divided = _divided(copies, cells, cells.shapes.soft)
    written = (divided.share >= 0) & known
    _warp(copies, cells, divided, written, made)
    if cells.loose:
        other = ndimage.binary_dilation(known & cells.shows_element(before))
        made = np.where(written & (other | seen_of(made, written, cells)), made, before)
    return torch.from_numpy(made).to(places)


def _divided(copies: Copies, cells: Cells, aways: Array) -> _Divided:
    """How the plane is divided among copies, of which pixels are so far away."""
    from kwatra.pieces.cells.loops import divide

    shape = copies.number.shape
    best, second, share = np.empty(shape, np.float32), np.empty(shape, np.float32), np.empty(shape, np.int64)
    divide(cells.shapes.windows, aways, tuple(copies.laid), best, second, share)
    share[copies.stays] = -1
    return _Divided(share, best, second)


def _warp(copies: Copies, cells: Cells, divided: _Divided, written: Array, made: Array) -> None:
    """Have shares show whole cells: set the places `made` (2, H, W) that are written (H, W)."""
    from kwatra.pieces.cells.rays import warp

    shapes, how = cells.shapes, (cells.rays, STRETCHED, cells.gaps)
    values = shapes.windows, shapes.away, shapes.element, cells.whole
    warp(*values, tuple(copies.laid), *how, divided.best, divided.second, divided.share, written, made)


def _astray(where: Array, cells: Cells, copies: Copies, share: Array) -> tuple[Array, Array]:
    """Which copies (m,) do not have their place, and which pixels (H, W) are of elements that have none there.

    All of an element is to be in its share, and nothing of another.
    """
    element, own, room = cells.shows_element(where) & (share >= 0), copies.number == share, copies.elements
    others = element & ~own
    placed, found = (np.bincount(share[some], minlength=len(room)) for some in (element & own, others))
    return (placed < (1 - MISSED) * room) | (found > MISSED * room), others
