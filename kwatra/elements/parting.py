"""How a picture falls into parts that a ground lies between: where they meet, and how much they differ in color."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy import ndimage

Array = np.ndarray[Any, Any]


class Variance:
    """The variance of an exemplar's colors (C, *S) over some of its pixels, as a share of the `total` over all inside.

    Sums are `einsum`'s, which are the same bits for any number of threads, as those of matrix products are not.
    """

    def __init__(self, colors: Array, inside: Array) -> None:
        flat = (colors - colors[:, inside].mean(1)[:, None, None]).reshape(len(colors), -1)
        self._powers = np.concatenate([flat, flat**2])
        self.total = self._summed(inside)

    def _summed(self, part: Array) -> float:
        """The variances of all channels over a part (*S) of the pixels, 0 of none."""
        count = np.count_nonzero(part)
        first, second = np.split(np.einsum("ik,k->i", self._powers, part.ravel().astype(float)) / max(count, 1), 2)
        return float((second - first**2).sum())

    def share(self, part: Array) -> float:
        """The share of a part (*S), at most 1; 0 where all have one color."""
        return min(self._summed(part) / self.total, 1.0) if self.total > 0 else 0.0


def deviations(values: Array, middle: Array, covariance: Array) -> Array:
    """How far values (k, *N) are from a middle (k,), each direction counted in how much varies along it, (*N)."""
    from kwatra.elements.alikeloops import factor, measure

    lower, away = np.zeros(covariance.shape), np.empty(values[0].size)
    factor(covariance, lower)
    measure(values.reshape(len(values), -1), middle, lower, away)
    return np.sqrt(away).reshape(values.shape[1:])


def between_parts(colors: Array, number: Array, inside: Array) -> float:
    """The variance of the parts' mean colors, as a share of that of all colors (C, *S) inside (*S).

    number (*S): of the part that a pixel is of, from 1; 0 of none.
    """
    numbers = number[number > 0]
    area, total = np.bincount(numbers), float(colors[:, inside].var(1).sum())
    if numbers.size == 0 or total == 0:
        return 0.0
    between = 0.0
    for channel in colors:
        means = np.bincount(numbers, channel[number > 0]) / np.maximum(area, 1)
        between += float((area * np.square(means - channel[inside].mean())).sum()) / numbers.size
    return between / total


TIP = 4
"""px^2 that the border leaves of a part at least. Not tuned."""


def parted(ground: Array, inside: Array, least: float) -> Array:
    """The parts (*S), by number, that ground (*S) leaves of what is inside (*S); 0 of smaller ones than least, px^2.

    What the border cuts may be smaller: it is the tip of a part.
    """
    number, count = ndimage.label(inside & ~ground)
    area = np.bincount(number.ravel(), minlength=count + 1)
    small, cut = area < least, at_edge(number, inside)
    small[cut] = area[cut] < min(TIP, least)
    number[small[number]] = 0
    return number


def at_edge(number: Array, inside: Array) -> Array:
    """The numbers (n,), but for 0, of parts (*S) that the border cuts, or what is not inside (*S)."""
    cut = np.unique(number[inside & ndimage.binary_dilation(~inside, border_value=1)])
    some: Array = cut[cut > 0]
    return some


def meeting(ground: Array, values: Array, inside: Array, least: float) -> Array:
    """The same grown until they meet; 0 there.

    They meet, along lines of one pixel, where values (*S) are least (Meyer 1994, "Topographic distance and watershed
    lines").
    """
    from skimage.segmentation import watershed  # takes a tenth of a second; few pictures need it

    met: Array = watershed(-values, parted(ground, inside, least), mask=inside, watershed_line=True)
    return met


def touching(parts: Array) -> Iterator[tuple[Any, Any, Array]]:
    """Per axis the index of pixels, of those before them, and where these are of two parts (H, W); 0 is no part."""
    for index, before in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        one, other = parts[index], parts[before]
        yield index, before, (one != other) & (one > 0) & (other > 0)


def usual_area(area: Array) -> float:
    """The area of the part that the middle pixel is of, were pixels sorted by that; 1 without any parts.

    area (n,): of each part.
    """
    sizes = np.sort(area)
    return float(sizes[np.searchsorted(sizes.cumsum(), sizes.sum() / 2)]) if sizes.size else 1.0
