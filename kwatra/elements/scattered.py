"""How unlike most of a picture its pixels are: elements scattered on ground that is a texture of its own.

No color tells such ground from elements: sand is as dark as some pebbles on it, and as light as others. But most of the
picture is ground, and elements are the exceptions. So that half of the pixels is sought that are most alike, in color
and in how much brightness varies around them: the covariance of what they are has the least determinant (Rousseeuw
1984, "Least median of squares regression"). It is found by steps each of which lowers that (Rousseeuw and Van Driessen
1999, "A fast algorithm for the minimum covariance determinant estimator"). What is far from it is an exception.
"""

import numpy as np

from kwatra.elements.contrast import ROUNDING, frequent, smoothed
from kwatra.elements.parting import Array, deviations

GRAIN, AROUND = 1.0, 2.5
"""Colors are smoothed by so many pixels, how brightness varies by the second. Of 54 textures made in code, of nine
kinds and two sizes, ground is found of 51, in which .92 of the pixels are shared by what is found and what is so
(F1, .74 at least); in gray of 14. With 1.5 and 3.5 around it is the same but for gray, of which it is 9 and 14."""

FLAT = 1e-4
"""Variances of no more are none; colors are 0 to 1, or then have a variance of 1. Not tuned."""

STARTS, STEPS, SOME = 4, 30, 2000
"""The half is sought from near so many frequent colors on, in so many steps at most, among so many pixels: bounds on
time."""


def unlike_most(colors: Array, inside: Array) -> Array:
    """How far pixels (*S) are from that half of those inside (*S) that are most alike; the half is no further than 1.

    colors (C, *S), 0 to 1. Infinite outside.
    """
    values = _described(colors, inside)[:, inside]
    values /= np.maximum(values.std(1, keepdims=True), ROUNDING)
    some = np.ascontiguousarray(values[:, np.random.default_rng(0).permutation(values.shape[1])[:SOME]])
    halves = [_most_alike(some, start) for start in frequent(some[: len(colors)], STARTS)]
    away = deviations(values, *min(halves, key=lambda half: np.linalg.slogdet(half[1])[1]))
    unlike = np.full(inside.shape, np.inf)
    unlike[inside] = away / max(float(np.median(away)), ROUNDING)
    return unlike


def _described(colors: Array, inside: Array) -> Array:
    """Colors (C, *S), smoothed, and the logarithm of how much brightness deviates around each pixel: (C + 1, *S)."""
    smooth = np.stack([smoothed(channel, inside, GRAIN) for channel in colors])
    varies = smoothed(np.square(colors.mean(0) - smooth.mean(0)), inside, AROUND)
    return np.stack([*smooth, 0.5 * np.log(varies + FLAT)])


def _most_alike(values: Array, start: Array) -> tuple[Array, Array]:
    """The mean (k,) of a half of values (k, n), and its covariance (k, k).

    start (c,): the half begins as what is nearest to it in the first c values.
    """
    from kwatra.elements.alikeloops import find_half

    middle, varied = np.empty(len(values)), np.empty((len(values), len(values)))
    find_half(values, start, STEPS, FLAT, middle, varied)
    return middle, varied
