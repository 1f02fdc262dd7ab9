"""The outlines of elements that touch or overlap, with no ground between them: mosaics without joints, confetti.

Edges part such a picture into parts of about one color each, as large as elements. So the strongest edges are taken
away, for several shares of the pixels, and what is left is judged as what a ground leaves (`kwatra.elements.splits`).
From these parts the picture is filled, what is steepest last (Meyer 1994, "Topographic distance and watershed lines"):
two parts meet where it changes most.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements.ground import AS_SURE
from kwatra.elements.kept import kept
from kwatra.elements.parting import Array, between_parts, parted
from kwatra.elements.size import element_size
from kwatra.elements.splits import SPECK, cleaned, depth_beside
from kwatra.exemplar import Exemplar

SMOOTHING = 1.0
"""Colors are smoothed by so many pixels before edges are looked for: noise makes none. Of stills of mosaics without
joints and confetti, twelve exemplars, .040 of the boundaries are torn, .060 with .7, .123 without outlines."""

EDGES = (0.12, 0.2, 0.3, 0.4)
"""Shares of the pixels that are tried as edges; six between .08 and .4 leave as much torn."""

FLAT, SHADED = 0.9, 0.75
"""Outlines hide seams if FLAT of the variance of colors lies between parts, and none if SHADED.

In mosaics without joints and confetti made in code .88 and more does; in photographs whose edges enclose parts .67 and
less, in a wall of bricks of one color .42. Seams along the edges of such photographs score .062 for .051 (nine)."""

SURE = 0.1
"""Parts that are elements less surely are none: as little as of ground, not tuned."""

MIXED, NOISE = 0.25, 4.0
"""A pixel beside an outline is of both parts' colors if the steps to it and from it are both more than MIXED of what
they come to, and more than NOISE times the median step: what is less is not seen. Without, seams beside soft outlines
are dashed lines of a third color; with twice the median as many boundaries are torn, by .2 and .3 as many."""


@dataclass(frozen=True)
class Outlines:
    """Which part of an exemplar's canvas each pixel belongs to.

    parts (*S): its number from 1; 0 for none, where it is of two parts' colors. depth (*S): 0 beside an outline, and
    more within parts, to 1 a quarter of an element's size from it. hides: 0 to 1, how surely parts are elements, each
    of one color, so that where one ends it need not go on. size: that of an element, in pixels.
    """

    parts: Array
    depth: Array
    hides: float
    size: float


class _Parted(NamedTuple):
    """markers (*S): the parts that edges leave, by number, 0 for edges. hides: as in `Outlines`."""

    markers: Array
    hides: float


@kept
def find_outlines(exemplar: Exemplar) -> Outlines | None:
    """The outlines of an exemplar of still images, None in textures of another kind."""
    size, owner = element_size(exemplar), exemplar.owner.long().numpy()
    inside, colors = owner >= 0, exemplar.canvas.double().numpy()
    steep = _steepness(colors)
    tried = [_parted(colors, steep > np.quantile(steep[inside], 1 - share), owner, size) for share in EDGES]
    most = max(one.hides for one in tried)
    if most < SURE:
        return None
    found = next(one for one in tried if one.hides >= AS_SURE * most)
    from skimage.segmentation import find_boundaries, watershed  # take a tenth of a second; few pictures have outlines

    parts = watershed(steep, found.markers, mask=inside)
    outline = find_boundaries(parts, connectivity=1, mode="thick")
    depth = depth_beside(outline, size)
    parts[outline & _mixed(colors)] = 0
    return Outlines(parts, depth, found.hides, size)


def _steepness(colors: Array) -> Array:
    """How much colors (C, *S) change from pixel to pixel."""
    each = (ndimage.gaussian_gradient_magnitude(channel, SMOOTHING) for channel in colors)
    steep: Array = np.sqrt(sum(np.square(channel) for channel in each))
    return steep


def _parted(colors: Array, edges: Array, owner: Array, size: float) -> _Parted:
    """The parts into which edges (*S) part colors (C, *S)."""
    inside = owner >= 0
    edges, sure, _ = cleaned(edges & inside, owner, size)
    markers = parted(edges, inside, SPECK * size**2)
    flat = (between_parts(colors, markers, inside) - SHADED) / (FLAT - SHADED)
    return _Parted(markers, sure * min(max(flat, 0.0), 1.0))


def _mixed(colors: Array) -> Array:
    """Where (*S) colors (C, *S) lie between those of the pixels before and after, off both."""
    mixed = np.zeros(colors.shape[1:], bool)
    for channels, between in ((colors, mixed), (colors.swapaxes(1, 2), mixed.T)):
        if channels.shape[1] < 3:
            continue
        steps = np.sqrt(np.square(channels[:, 1:] - channels[:, :-1]).sum(0))
        both = np.sqrt(np.square(channels[:, 2:] - channels[:, :-2]).sum(0))
        least = np.maximum(MIXED * both, NOISE * np.median(steps))
        between[1:-1] |= np.minimum(steps[1:], steps[:-1]) > least
    return mixed
