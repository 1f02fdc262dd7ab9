"""Elements up to their rims and no further, where the ground between them is wide and plain.

What is as dark as half-way between ground and elements is taken for ground at first, and so are the rims of dark
elements, which would be cut off and left behind. Wide ground tells by itself what it looks like.
"""

import numpy as np
from scipy import ndimage

from kwatra.elements.ground import SPECK
from kwatra.pieces.seams import Array, Parts

FAR, SOME = 3, 0.05
"""Ground is plain so many pixels from any element, if it is so much of the exemplar at least: joints of stones made in
code are nowhere as wide, the ground of coins is .2 of them and more."""

UNLIKE = 4.0
"""Pixels are no ground that differ from it by so many of its usual deviations. Of coins of 12, 20 and 32 px made in
code 36, 12 and 0 pixels are then taken for ground, 1101, 12 and 949 without."""

FAINT = 0.3
"""Nor by less than so much of what elements usually do, as blurred edges do. Four stills of a twill score .102 with .1,
.076 with .25, .066 with .35, .072 without rims; coins are found as well with all."""

WIDEST, EDGE = 0.15, 2
"""Rims are at most so much of an element's size wide, and what looks like ground at their edge so many pixels. Not
tuned."""


def plain_ground(number: Array, inside: Array) -> Array | None:
    """Where (*S) what is `inside` (*S) is ground far from all elements, by number (*S), > 0; None if that is little."""
    plain = inside & (ndimage.distance_transform_edt(number <= 0) >= FAR)
    return plain if np.count_nonzero(plain) >= max(SOME * np.count_nonzero(inside), 1) else None


def with_rims(parts: Parts, colors: Array, inside: Array, plain: Array) -> Parts:
    """Parts with what lies beside them and does not look like plain ground, without what looks so along their edge.

    What is then a speck is none, and others are numbered anew. plain (*S): where ground is plain. colors (C, *S): of
    the exemplar's canvas; inside (*S): what of it there is.
    """
    element = parts.number > 0
    off = np.linalg.norm(colors - np.median(colors[:, plain], 1)[:, None, None], axis=0)
    unlike = inside & (off > max(UNLIKE * np.median(off[plain]), FAINT * np.median(off[element])))
    ground = ndimage.binary_dilation(~element, iterations=EDGE, mask=~element | (inside & ~unlike))
    widest = max(round(WIDEST * parts.size), 1)
    grown = ndimage.binary_dilation(~ground, iterations=widest, mask=~ground | unlike)
    near = ndimage.distance_transform_edt(~element, return_distances=False, return_indices=True)
    number = np.where(grown, parts.number[tuple(near)], 0)
    large = np.bincount(number.ravel(), minlength=1) >= SPECK * parts.size**2
    large[0] = False
    renumbered = np.where(large, np.cumsum(large), 0)[number]
    return parts._replace(number=np.where(renumbered > 0, renumbered, np.minimum(parts.number, 0)))
