"""The patterns of a texture without being told: its elements, each with its outline as landmarks."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from skimage import measure

from kwatra.base import InputError
from synth.metamorphosis.elements import Elements, elements
from synth.metamorphosis.patterns.detection import detect
from synth.metamorphosis.patterns.landmarks import Patterns
from synth.metamorphosis.patterns.outlines import outline
from synth.words import counted

Array = NDArray[np.float64]

COUNT = 16
"""Landmarks of an outline."""
LEAST = 4
"""Fewer patterns than this make no metamorphosis of textures."""
SURE = 0.24
"""Elements are distinct from here on: bricks, stones, tiles and pebbles lie at .28 to .67, bands of onyx, marble, bark
and grass at .12 to .22."""


@dataclass(frozen=True)
class Found:
    """The patterns of a texture, all of them; sure, 0 to 1, that they are, or None where a person said so."""

    patterns: Patterns
    every: Array
    sure: float | None

    @property
    def remark(self) -> str:
        """What was found, in words."""
        said = f"{len(self.every)} patterns"
        if self.sure is None:
            return said
        doubt = f"; below {SURE} they are hardly distinct: look at them" if self.sure < SURE else ""
        return f"{said}, sure by {self.sure:.2f} of 1{doubt}"


def patterns_of(
    image: Array,
    given: Patterns | None = None,
    threshold: float | None = None,
    name: str = "the image",
    least: float = SURE,
) -> Found:
    """The patterns of an image (H, W, C) in [0, 1].

    given: landmarks of one of them, for which the others are detected, or all of them, which are taken as they are.
    threshold: of `detect`. Without any they are the elements of the image, which are to be as sure as `least`.

    Raises InputError if fewer than 4 are found, or what is found is less sure.
    """
    if given is None:
        return _own(image, name, least)
    if given.size != image.shape[:2]:
        raise InputError(
            f"the patterns are of an image of {given.size[1]}x{given.size[0]} but {name} is "
            f"{image.shape[1]}x{image.shape[0]}; give those of this image"
        )
    found = detect(image, given.landmarks, threshold).landmarks if given.found is None else given.found
    if len(found) < LEAST:
        raise InputError(
            f"found {counted(len(found), 'pattern')} in {name}; patterns needs at least {LEAST}: give landmarks of one "
            "that repeats, or a higher threshold"
        )
    return Found(replace(given, found=found), found, None)


def _own(image: Array, name: str, least: float) -> Found:
    """The elements of an image as patterns; the representative one is the most like all others."""
    split = elements(image)
    if split.count < LEAST:
        raise InputError(
            f"found {counted(split.count, 'pattern')} in {name}; patterns needs at least {LEAST}: give landmarks of "
            "one that repeats, or use another method"
        )
    if split.sure < least:
        raise InputError(
            f"found no distinct elements in {name} (sure by {split.sure:.2f} of 1, {least} is needed); look at what "
            "`kwatra patterns` finds and give its file, or landmarks of a pattern that repeats, or use another method"
        )
    outlines = _outlines(split)
    representative = outlines[_most_typical(outlines, split)]
    patterns = Patterns((image.shape[0], image.shape[1]), representative, outlines, closed=True)
    return Found(patterns, outlines, split.sure)


def _most_typical(outlines: Array, split: Elements) -> int:
    """The number of the outline (n, m, 2) nearest to the median shape, of those that the border does not cut if any."""
    own = outlines - outlines.mean(1, keepdims=True)
    away = np.square(own - np.median(own, 0)).sum((1, 2))
    cut = np.unique(np.concatenate([split.labels[[0, -1]].ravel(), split.labels[:, [0, -1]].ravel()]))
    whole = ~np.isin(np.arange(1, len(outlines) + 1), cut)
    return int(np.where(whole | ~whole.any(), away, np.inf).argmin())


def _outlines(split: Elements) -> Array:
    """The outlines (n, COUNT, 2) of all elements."""
    shape = split.labels.shape
    found = []
    for part in measure.regionprops(split.labels):
        top, left, _, _ = part.bbox
        found.append(outline(part.image_filled, COUNT) + np.array([left, top]))
    return np.clip(np.stack(found), 0, [shape[1] - 1, shape[0] - 1])
