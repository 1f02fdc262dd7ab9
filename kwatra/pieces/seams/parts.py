"""The elements of an exemplar one by one, where gaps or outlines hide seams."""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements.splits import RIM
from kwatra.pieces.seams.gaps import Hidden
from kwatra.pieces.seams.stock import Array

MIDDLE = 0.5
"""Elements that touch are told apart by what is deeper than this. Not tuned."""

FARTHEST = 2.0
"""Pixels are of the element whose inside is at most so many pixels away; a rim is hardly wider. Not tuned."""


class Parts(NamedTuple):
    """The elements of an exemplar's canvas.

    number (*S): that of the element each place is of, from 1; 0 of the ground, -1 of what is nobody's. core (*S):
    whether it is more than a pixel inside of it, or it is nowhere thicker. deep (*S): 0 on the ground to 1 a quarter of
    their size inside. size: of one, px.
    """

    number: Array
    core: Array
    deep: Array
    size: float

    @property
    def nearest(self) -> Array:
        """The number (*S) of the element that is nearest to each place; if there is none it means nothing."""
        near = ndimage.distance_transform_edt(self.number <= 0, return_distances=False, return_indices=True)
        number: Array = self.number[tuple(near)]
        return number

    def whole(self, inside: Array) -> Array:
        """Which numbers, from 0, are of elements that neither the border nor what is not `inside` (*S) cuts."""
        edge = ndimage.binary_dilation(~np.pad(inside, 1), iterations=2)[(slice(1, -1),) * inside.ndim]
        whole = np.ones(int(self.number.max()) + 1, bool)
        whole[np.unique(self.number[edge].clip(min=0))] = whole[0] = False
        return whole


def parts_of(hidden: Hidden, inside: Array) -> Parts:
    """The elements between which seams are hidden, of what is `inside` (*S) of the exemplar's canvas alone."""
    deep = 1 - (1 - hidden.depth.astype(np.float64)) / hidden.hides
    steps = deep * max(RIM * hidden.size, 1.0)  # px from the ground
    core = (steps > 1.2) & inside  # not beside it
    core |= _without((steps > 0.5) & inside, core)
    number = told_apart(core, deep)
    away, near = ndimage.distance_transform_edt(~core, return_indices=True)
    element = inside & (steps > 0.5) & (away <= FARTHEST)
    number = np.where(element, number[tuple(near)], np.where(inside, 0, -1))
    return Parts(number, core, deep, hidden.size)


def told_apart(core: Array, deep: Array) -> Array:
    """The number (*S) of the element whose core (*S) a place is of, 0 of none: they part where they are least deep."""
    from skimage.segmentation import watershed  # takes a tenth of a second; few pictures have elements

    markers, count = ndimage.label(core & (deep > MIDDLE))
    hanging, _ = ndimage.label(core)
    markers = np.where(_without(core, markers > 0), count + hanging, markers)  # what is nowhere deep is one
    numbers = np.unique(watershed(-deep, markers, mask=core), return_inverse=True)[1].reshape(core.shape)
    number: Array = numbers if not core.all() else numbers + 1
    return number


def _without(pixels: Array, some: Array) -> Array:
    """What of pixels (*S) hangs together and has none of some (*S)."""
    hanging, count = ndimage.label(pixels)
    without = np.ones(count + 1, bool)
    without[np.unique(hanging[some])] = without[0] = False
    found: Array = without[hanging]
    return found
