"""Elements up to their rims and no further, where the ground between them is wide and plain.

What is as dark as half-way between ground and elements is taken for ground at first, and so are the rims of dark
elements, which would be cut off and left behind; so is what the border leaves of an element, if that is little. Wide
ground tells by itself what it looks like.
"""

import numpy as np
from scipy import ndimage

from kwatra.elements.parting import at_edge, deviations
from kwatra.elements.splits import SPECK, depth_beside
from kwatra.pieces.seams import Array, Parts
from kwatra.pieces.seams.parts import told_apart

FAR, SOME = 3, 0.05
"""Ground is plain so many pixels from any element, if it is so much of the exemplar at least: joints of stones made in
code are nowhere as wide, the ground of coins is .2 of them and more."""

UNLIKE, ROUNDED = 4.0, 1 / 255
"""Pixels are no ground whose colors are so many times as far from it as is usual, each direction counted in how much
ground varies along it, and in rounding. Of coins of 12, 20 and 32 px made in code 2, 0 and 0 pixels are then taken for
ground, 1101, 12 and 949 without, and 36, 12 and 0 if all directions count the same."""

FAINT = 0.1
"""Nor by less than so much of what elements usually do. With .3 shaded rims of sweets on wood are cut off, by eye; with
.03 coins and buttons are found as with it."""

TIP = 3
"""So many pixels at the border that are no ground are the tip of an element that it cuts. Not tuned."""

WIDEST, EDGE = 0.15, 2
"""Rims are at most so much of an element's size wide, and what looks like ground at their edge so many pixels. Not
tuned."""


def plain_ground(number: Array, inside: Array) -> Array | None:
    """Where (*S) what is `inside` (*S) is ground far from all elements, by number (*S), > 0; None if that is little."""
    plain = inside & (ndimage.distance_transform_edt(number <= 0) >= FAR)
    return plain if np.count_nonzero(plain) >= max(SOME * np.count_nonzero(inside), 1) else None


def with_rims(parts: Parts, colors: Array, inside: Array, plain: Array) -> Parts:
    """Parts with what lies beside them and does not look like plain ground, without what looks so along their edge.

    What is then a speck is none, and others are told apart anew, as some hung together by what looks like ground. plain
    (*S): where ground is plain. colors (C, *S): of the exemplar's canvas; inside (*S): what of it there is.
    """
    element, off = parts.number > 0, _off(colors, plain)
    unlike = inside & _unlike(colors, plain) & (off > FAINT * np.median(off[element]))
    ground = ndimage.binary_dilation(~element, iterations=EDGE, mask=~element | (inside & ~unlike))
    widest = max(round(WIDEST * parts.size), 1)
    grown = ndimage.binary_dilation(~ground, iterations=widest, mask=~ground | unlike)
    number = told_apart(grown, depth_beside(~grown, parts.size))
    large = np.bincount(number.ravel(), minlength=1) >= SPECK * parts.size**2
    large[0] = False
    renumbered = np.where(large, np.cumsum(large), 0)[number]
    return parts._replace(number=np.where(renumbered > 0, renumbered, np.minimum(parts.number, 0)))


def tips(number: Array, colors: Array, inside: Array, plain: Array) -> Array:
    """Where (*S) the border, or what is not inside (*S), cuts elements of which it leaves too little to be numbered.

    number, plain, colors: as of `with_rims`.
    """
    free = inside & (number <= 0) & _unlike(colors, plain)
    parts, _ = ndimage.label(free, np.ones((3, 3)))
    rims = parts[ndimage.binary_dilation(number > 0, iterations=EDGE)]
    cut, area = np.setdiff1d(at_edge(parts, inside), rims), np.bincount(parts.ravel())
    found: Array = np.isin(parts, cut[area[cut] >= TIP])
    return found


def _unlike(colors: Array, plain: Array) -> Array:
    """Which colors (C, *S) differ from plain ground (*S), by how it varies."""
    ground = colors[:, plain]
    varied = np.cov(ground).reshape(len(colors), -1) + ROUNDED**2 * np.eye(len(colors))
    off = deviations(colors, ground.mean(1), varied)
    unlike: Array = off > UNLIKE * np.median(off[plain])
    return unlike


def _off(colors: Array, plain: Array) -> Array:
    """How far colors (C, *S) are from those of plain ground (*S)."""
    off: Array = np.linalg.norm(colors - np.median(colors[:, plain], 1)[:, None, None], axis=0)
    return off
