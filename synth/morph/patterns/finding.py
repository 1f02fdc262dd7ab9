"""The patterns of a texture without being told: its elements, each with its outline as landmarks."""

import numpy as np
from numpy.typing import NDArray
from skimage import measure

from kwatra.base import InputError
from synth.morph.elements import Elements, elements
from synth.morph.patterns.detection import detect
from synth.morph.patterns.landmarks import Patterns
from synth.morph.patterns.outlines import outline

Array = NDArray[np.float64]

COUNT = 16
"""Landmarks of an outline."""
LEAST = 4
"""Fewer patterns than this make no metamorphosis of textures."""
SURE = 0.18
"""Elements are distinct from here on: brick, stones, tiles and pebbles lie at .2 to .6, bands of onyx at .1 to .15."""


def patterns_of(
    image: Array, given: Patterns | None = None, threshold: float | None = None, name: str = "the image"
) -> tuple[Patterns, float]:
    """The patterns of an image (H, W, C) in [0, 1], and how sure it is that they are, 0 to 1.

    given: landmarks of one of them, for which the others are detected, or all of them, which are taken as they are
    (both are sure). threshold: of `detect`. Without any they are the elements of the image.

    Raises InputError if fewer than 4 are found, or what is found is hardly distinct elements.
    """
    if given is not None and given.size != image.shape[:2]:
        raise InputError(
            f"the patterns are of an image of {given.size[1]}x{given.size[0]} but {name} is "
            f"{image.shape[1]}x{image.shape[0]}; give those of this image"
        )
    patterns, sure = _own(image, name) if given is None else (given, 1.0)
    if patterns.found is None:
        found = detect(image, patterns.landmarks, threshold).landmarks
        patterns = Patterns(patterns.size, patterns.landmarks, found, patterns.closed)
    count = 0 if patterns.found is None else len(patterns.found)
    if count < LEAST:
        raise InputError(
            f"found {count} patterns in {name}; patterns needs at least {LEAST}: give landmarks of one that repeats, or "
            "a higher threshold"
        )
    return patterns, sure


def _own(image: Array, name: str) -> tuple[Patterns, float]:
    """The elements of an image as patterns; the representative one is the most like all others."""
    split = elements(image)
    if split.count < LEAST:
        raise InputError(
            f"found {split.count} patterns in {name}; patterns needs at least {LEAST}: give landmarks of one that "
            "repeats, or use another method"
        )
    if split.sure < SURE:
        raise InputError(
            f"found no distinct elements in {name} (sure by {split.sure:.2f}, {SURE} is needed); give landmarks of a "
            "pattern that repeats, or use another method"
        )
    outlines = _outlines(split)
    own = outlines - outlines.mean(1, keepdims=True)
    middle = np.square(own - np.median(own, 0)).sum((1, 2)).argmin()
    return Patterns((image.shape[0], image.shape[1]), outlines[middle], outlines, closed=True), split.sure


def _outlines(split: Elements) -> Array:
    """The outlines (n, COUNT, 2) of all elements."""
    shape = split.labels.shape
    found = []
    for part in measure.regionprops(split.labels):
        top, left, _, _ = part.bbox
        found.append(outline(part.image_filled, COUNT) + [left, top])
    return np.clip(np.stack(found), 0, [shape[1] - 1, shape[0] - 1])
