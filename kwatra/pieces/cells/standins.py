"""Whole elements that stand in for those that the exemplar's border cuts, where they look alike.

Nobody knows how an element goes on that the border cuts. Coins and tiles are all of one form: a whole one shows it.
Stones differ; there what is seen of one is drawn out over the rest.
"""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.base.transforms import backward, fast, forward
from kwatra.pieces.seams import Array

ALIKE = 0.1
"""A whole element stands in for one of which so much of what is seen differs in form at most. Of 16 coins and 19 tiles
of 20 and 32 px made in code that the border cuts all but two do, of 31 stones 6."""

COLORS = 0.3
"""What it counts that colors differ, 1 for those of any two elements, beside form. Not tuned."""

MOST = 64
"""So many whole elements are looked at, or about as many, evenly chosen of all. A bound on time and memory."""

AROUND = 8
"""An element is compared with so many pixels of what is around its cell. A bound on time."""


class _Seen(NamedTuple):
    """A cell's window on the canvas: its first place (2,), what is known of it (h, w), which pixels are the element's.

    looks (1 + C, h, w): their colors, and the squares of these together.
    """

    first: Array
    known: Array
    element: Array
    looks: Array


def stand_ins(number: Array, element: Array, colors: Array, cut: Array, whole: Array) -> tuple[Array, Array]:
    """Which cell (n,) is drawn for each, mostly itself, and how much further (n, 2) on the canvas its places are.

    number (*S): of the cell that each place of the canvas belongs to, from 1; element (*S): whether it is of its
    element; colors (C, *S). cut, whole (n,): which cells look for another, and among which. Memory is that of some
    transforms, of windows twice as large, for each whole cell that is looked at.
    """
    instead, further = np.arange(len(cut)), np.zeros((len(cut), 2), np.int64)
    if not (cut.any() and whole.any()):
        return instead, further
    spread = 2 * float(colors[:, element].var(1).sum())  # by so much two pixels of elements differ
    scaled = colors * np.sqrt(COLORS / spread if spread > 0 else 0.0)
    boxes, mine, others = ndimage.find_objects(number), np.flatnonzero(cut).tolist(), np.flatnonzero(whole).tolist()
    others = others[:: -(-len(others) // MOST)]
    seen = {cell: _seen(cell, boxes[cell - 1], number, element, scaled) for cell in mine + others}
    size = fast([2 * max(one.known.shape[axis] for one in seen.values()) for axis in range(2)])
    forms = np.stack([forward(seen[cell].element.astype(np.float32), size) for cell in others])
    for cell in mine:
        own, area = seen[cell], np.count_nonzero(seen[cell].element)
        differing = _forms_differing(own, forms, size)
        alike = np.flatnonzero(differing.min((1, 2)) <= ALIKE * area)
        if not len(alike):
            continue
        colored = np.stack([forward(seen[others[k]].looks, size) for k in alike])
        cost = differing[alike] + _colors_differing(own, forms[alike], colored, size)
        cost[differing[alike] > ALIKE * area] = np.inf
        best, *at = np.unravel_index(int(np.argmin(cost)), cost.shape)
        other = others[alike[best]]
        moved = [int(far) - length if far > length // 2 else int(far) for far, length in zip(at, size, strict=True)]
        instead[cell], further[cell] = other, np.array(moved) + seen[other].first - own.first
    return instead, further


def _seen(cell: int, box: tuple[slice, ...], number: Array, element: Array, colors: Array) -> _Seen:
    """What is seen of a cell, whose box it is."""
    around = [(max(side.start - AROUND, 0), side.stop + AROUND) for side in box]
    at = tuple(slice(first, stop) for first, stop in around)
    own = (number[at] == cell) & element[at]
    shown = (colors[(slice(None), *at)] * own).astype(np.float32)
    return _Seen(
        np.array([first for first, _ in around]), number[at] > 0, own, np.stack([*shown, np.square(shown).sum(0)])
    )


def _forms_differing(own: _Seen, forms: Array, size: tuple[int, ...]) -> Array:
    """By how many pixels (k, *size) an element differs from others, moved, where it is known; of their transforms."""
    known, element = np.conj(forward(np.stack([own.known, own.element]).astype(np.float32), size))
    differing: Array = backward((known - 2 * element) * forms, size, size) + np.count_nonzero(own.element)
    return differing


def _colors_differing(own: _Seen, forms: Array, colored: Array, size: tuple[int, ...]) -> Array:
    """By how much colors (k, *size) differ where both elements are; of the others' transforms (k, ...), as `looks`."""
    element, *colors, squares = np.conj(forward(np.stack([own.element, *own.looks]).astype(np.float32), size))
    both = squares * forms + element * colored[:, -1] - 2 * (np.stack(colors) * colored[:, :-1]).sum(1)
    return backward(both, size, size)
