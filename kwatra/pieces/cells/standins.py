"""Whole elements that stand in for those that the exemplar's border cuts, where they look alike.

Nobody knows how an element goes on that the border cuts. Coins and tiles are all of one form: a whole one shows it.
Stones differ; there what is seen of one is drawn out over the rest.
"""

from typing import NamedTuple

import numpy as np
from scipy import fft, ndimage

from kwatra.pieces.seams import Array

ALIKE = 0.1
"""A whole element stands in for one of which so much of what is seen differs in form at most. Of 16 coins and 19 tiles
of 20 and 32 px made in code that the border cuts all but two do, of 31 stones 6."""

COLORS = 0.3
"""What it counts that colors differ, 1 for those of any two elements, beside form. Not tuned."""

MOST = 64
"""So many whole elements are looked at, or about as many, evenly chosen of all. A bound on time and memory."""


class _Seen(NamedTuple):
    """A cell's window on the canvas: its first place (2,), what is known of it (h, w), which pixels are the element's.

    looks (2 + C, h, w): these, their colors, and the squares of these together.
    """

    first: Array
    known: Array
    element: Array
    looks: Array


def stand_ins(
    number: Array, element: Array, colors: Array, reach: int, cut: Array, whole: Array
) -> tuple[Array, Array]:
    """Which cell (n,) is drawn for each, mostly itself, and how much further (n, 2) on the canvas its places are.

    number (*S): of the cell that each place of the canvas belongs to, from 1; element (*S): whether it is of its
    element; colors (C, *S). reach: how far beyond cells it is looked, px. cut, whole (n,): which cells look for
    another, and among which. Memory is that of one transform, of windows twice as large, for each whole cell
    that is looked at.
    """
    instead, shift = np.arange(len(cut)), np.zeros((len(cut), 2), np.int64)
    if not (cut.any() and whole.any()):
        return instead, shift
    spread = 2 * float(colors[:, element].var(1).sum())  # by so much two pixels of elements differ
    scaled = colors * np.sqrt(COLORS / spread if spread > 0 else 0.0)
    boxes, others = ndimage.find_objects(number), np.flatnonzero(whole)
    seen = {
        int(cell): _seen(int(cell), boxes[cell - 1], number, element, scaled, reach)
        for cell in np.flatnonzero(cut | whole)
    }
    size = [fft.next_fast_len(2 * max(one.known.shape[axis] for one in seen.values()), real=True) for axis in range(2)]
    there = np.stack([fft.rfft2(seen[int(cell)].looks, size) for cell in others])
    for cell in np.flatnonzero(cut).tolist():
        own = seen[cell]
        form, color = _differing(own, there, size)
        at = np.unravel_index(int(np.argmin(form + color)), form.shape)
        if form[at] <= ALIKE * np.count_nonzero(own.element):
            moved = [far - length if far > length // 2 else far for far, length in zip(at[1:], size, strict=True)]
            instead[cell] = others[at[0]]
            shift[cell] = np.array(moved) + seen[others[at[0]]].first - own.first
    return instead, shift


def _seen(cell: int, box: tuple[slice, ...], number: Array, element: Array, colors: Array, reach: int) -> _Seen:
    """What is seen of a cell, whose box it is."""
    around = [(max(side.start - reach, 0), side.stop + reach) for side in box]
    at = tuple(slice(first, stop) for first, stop in around)
    own = (number[at] == cell) & element[at]
    shown = colors[(slice(None), *at)] * own
    looks = np.stack([own, *shown, np.square(shown).sum(0)]).astype(np.float32)
    return _Seen(np.array([first for first, _ in around]), number[at] > 0, own, looks)


def _differing(own: _Seen, there: Array, size: list[int]) -> tuple[Array, Array]:
    """By how many pixels forms differ (k, *size) of an element and others, moved, and by how much their colors do.

    Forms are compared where it is known, colors where both are. there (k, 2 + C, ...): the transforms of the others.
    """
    known, *looks = np.conj(fft.rfft2(np.stack([own.known.astype(np.float32), *own.looks]), size))
    is_own, colors, squares = looks[0], np.stack(looks[1:-1]), looks[-1]
    form = fft.irfft2((known - 2 * is_own) * there[:, 0], size) + np.count_nonzero(own.element)
    color = squares * there[:, 0] + is_own * there[:, -1] - 2 * (colors * there[:, 1:-1]).sum(1)
    return form, fft.irfft2(color, size)
