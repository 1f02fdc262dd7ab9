"""The ground that a texture's elements lie on: mortar, gaps, cloth, paper.

Ground is darker than elements, or lighter, and hangs together; what it leaves are parts about as large as an element.
So brightness, as it is and against its surroundings, is split at several values, and the split is taken that says so
most surely (compare Matas et al. 2002, "Robust wide baseline stereo from maximally stable extremal regions"). Of those
that say it as surely the one with least ground is taken, since the shaded rim of an element is not its gap. Where
elements are cut out, what is transparent is tried as well.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from kwatra.elements.kept import kept
from kwatra.elements.size import element_size
from kwatra.exemplar import Exemplar

Array = np.ndarray[Any, Any]

SMOOTHING = 0.7
"""Brightness is smoothed by so many pixels: noise makes no ground."""

ROUNDING = 1e-9
"""Brightness that differs by no more is one; it is 0 to 1."""

SPLITS = (0.08, 0.12, 0.17, 0.23, 0.3, 0.4)
"""Shares of the pixels that are tried as ground, beside the one at which two classes differ most (Otsu)."""

AS_SURE = 0.95
"""What is this share of the surest is as sure; with .9 and 1 stills of four textures with elements score the same."""

OPAQUE = 0.5
"""Alpha from which on a pixel is no ground: halfway, not tuned."""

HOLE, SPECK = 0.5, 0.04
"""Smaller parts, in areas of an element, are no ground, and no elements. This and the next two say what elements are;
they are not tuned."""

SMALL, LARGE = 0.1, 2.0
"""The areas between which a part is like an element, in squares of its size."""

MANY, COVER = 8, 0.3
"""So many elements, on so much of the picture, are enough to be sure."""

PLAIN, MIXED = 0.2, 0.3
"""Ground hides seams if its colors vary by at most PLAIN of what the picture's do, and none if by MIXED.

That of made stones varies by up to .2, and they are cut twice as often where it counts less. Along ground that is a
texture of its own (between pavers, tomatoes, bricks) hidden seams are seen: together with blocks that grow
(`kwatra.pieces.seams.gaps`) sixteen textures score .0628 for .0642."""

RIM = 0.25
"""An element is as deep as can be so far from the ground, in sizes of an element; half and twice as much is as good."""


@dataclass(frozen=True)
class Ground:
    """Where ground lies in an exemplar's canvas.

    depth (*S): 0 on the ground, and more within elements, to 1 a quarter of their size from it. sure: 0 to 1, how
    surely there is ground, and elements on it. plain: 0 to 1, how much alike its colors are, so that a seam upon it is
    hidden. size: that of an element, in pixels.
    """

    depth: Array
    sure: float
    plain: float
    size: float


@kept
def find_ground(exemplar: Exemplar) -> Ground:
    """The ground of an exemplar of still images. Textures without one have a `sure` of about 0."""
    size, owner = element_size(exemplar), exemplar.owner.long().numpy()
    inside = owner >= 0
    tried = [(light, *_cleaned(ground, owner, size)) for light, ground in _splits(exemplar, inside, size)]
    light, _, sure = max(tried, key=lambda split: split[2])
    alike = [ground for other, ground, as_sure in tried if other == light and as_sure >= AS_SURE * sure]
    least = min(alike, key=np.count_nonzero)
    away = ndimage.distance_transform_edt(np.pad(~least, 1, mode="edge"))[1:-1, 1:-1] if least.any() else inside
    depth = np.clip(away / max(RIM * size, 1.0), 0, 1)
    return Ground(depth, sure, _plain(exemplar.canvas.double().numpy(), inside, least), size)


def _plain(colors: Array, inside: Array, ground: Array) -> float:
    """How much alike the colors (C, *S) of the ground are: 1 for plain ground, 0 for one like a texture of its own."""
    every = float(colors[:, inside].var(1).sum())
    if every == 0 or not ground.any():
        return 1.0
    part = float(colors[:, ground].var(1).sum()) / every
    return min(max((MIXED - part) / (MIXED - PLAIN), 0.0), 1.0)


def _splits(exemplar: Exemplar, inside: Array, size: float) -> Iterator[tuple[bool, Array]]:
    """Ways to tell ground from elements, (*S) each, True on the ground; and whether it is lighter than they.

    Where all is as bright there is ground alone.
    """
    alpha = exemplar.alpha
    if alpha is not None:  # as it is: what is dark when smoothed holds opaque rims of elements
        yield False, (alpha < OPAQUE).numpy() & inside
    bright = _smoothed(exemplar.canvas.double().mean(0).numpy(), inside, SMOOTHING)
    around = _smoothed(bright, inside, max(size, 4.0))
    for light, values in ((False, bright), (True, -bright), (False, bright - around), (True, around - bright)):
        known = values[inside]
        if np.ptp(known) <= ROUNDING:
            yield light, inside
            continue
        for most in (_two_classes(known), *np.quantile(known, SPLITS)):
            yield light, (values <= most) & inside


def _smoothed(values: Array, inside: Array, sigma: float) -> Array:
    """Values (*S) blurred, of what is `inside` alone."""
    if inside.all():
        smooth: Array = ndimage.gaussian_filter(values, sigma)
        return smooth
    share = ndimage.gaussian_filter(inside.astype(float), sigma)
    part: Array = ndimage.gaussian_filter(np.where(inside, values, 0.0), sigma) / np.maximum(share, 1e-9)
    return part


def _two_classes(values: Array) -> float:
    """The value that splits values into the two classes whose means differ most (Otsu 1979)."""
    count, borders = np.histogram(values, 128)
    middle = (borders[1:] + borders[:-1]) / 2
    below, summed = np.cumsum(count)[:-1], np.cumsum(count * middle)[:-1]
    rest = values.size - below
    between = ((count * middle).sum() * below / values.size - summed) ** 2 / np.maximum(below * rest, 1)
    return float(borders[1 + int(np.argmax(between))])


def _cleaned(ground: Array, owner: Array, size: float) -> tuple[Array, float]:
    """Ground without holes in elements, and without specks upon it; and how surely it is one, 0 to 1.

    owner (*S): the image to which each pixel belongs, -1 for nobody. In each of them the ground hangs together.
    """
    parts, count = ndimage.label(ground, np.ones((3, 3)))
    area = np.bincount(parts.ravel(), minlength=count + 1)
    area[0] = 0
    if count == 0:
        return ground, 0.0
    image, largest = np.zeros(count + 1, owner.dtype), np.zeros(owner.max() + 1, area.dtype)
    image[parts.ravel()] = owner.ravel()
    np.maximum.at(largest, image[1:], area[1:])
    connected = largest.sum() / area.sum()
    ground = (area >= HOLE * size**2)[parts]
    inside = owner >= 0
    parts, count = ndimage.label(inside & ~ground)
    area = np.bincount(parts.ravel(), minlength=count + 1)
    area[0] = 0
    ground = ground | ((area > 0) & (area < SPECK * size**2))[parts]
    like = (area > SMALL * size**2) & (area < LARGE * size**2)
    cover, merged = area[like].sum() / inside.sum(), area[area >= LARGE * size**2].sum() / inside.sum()
    few = min(1.0, like.sum() / MANY) * min(1.0, cover / COVER)
    return ground, float(connected * few * cover / max(cover + merged, 1e-9))
