"""How well the blocks at all places of an exemplar agree with what is known of a box, in colors or in anything else."""

import math

import numpy as np

from kwatra.pieces.boxes import quantile
from kwatra.pieces.corners import Corners
from kwatra.pieces.fitting import Fit
from kwatra.pieces.stock import Array

GOOD = 0.05
"""Cost is counted in the mean (geometric) of the least disagreement and the one this share of blocks stays below. Half
and twice as much, as of ACCEPTABLE, MISMATCH_FLOOR and AGAIN, changes the score of four textures, .043, by .001."""

MISMATCH_FLOOR = 0.05
"""Disagreement, as a mean square relative to the exemplar's variance, that is hardly seen."""

FAIR = 0.25
"""What hangs over the exemplar is taken to agree with what is known as well as this share of blocks at least do.

Two panels of 16 textures score .052 and .058 with it, .052 and .059 with .5, and .055 and .065 without overhang."""


class Agreement:
    """Of an image (C, *S) of the exemplar, with blocks at `corners`, relative to a variance."""

    def __init__(self, image: Array, corners: Corners, variance: float) -> None:
        self.image, self.corners, self.variance = image, corners, variance
        self.fit = Fit(corners.around(image))

    def mismatch(self, place: Array, known: Array, valid: Array) -> Array:
        """The mean squared difference of each block to what is known (*E) of a box, shaped as `corners.valid`.

        place (axes, *E): where in the exemplar that comes from. What hangs over the exemplar is taken to agree as a
        fair one of the `valid` blocks does.
        """
        squares, seen = self.corners.squares(self.fit, self._shown(place, known), known)
        if any(self.corners.hang):
            fair = quantile((squares / np.maximum(seen, 1))[valid], FAIR)
            squares = squares + (known.sum() - seen) * fair
        mismatch: Array = squares / (known.sum() * self.variance)
        return mismatch

    def _shown(self, place: Array, known: Array) -> Array:
        """The image's values (C, *E) at the places (axes, *E) that are known (*E), and 0 elsewhere."""
        from kwatra.pieces.loops import take_known

        content = np.empty((len(self.image), *known.shape))
        image, there, shown = (values.reshape(len(values), -1) for values in (self.image, place, content))
        take_known(image, np.array(self.image.shape[1:]), there, known.ravel(), shown)
        return content


def attainable(mismatches: Array) -> float:
    """The disagreement that a texture affords, given that of all blocks in question: what others are measured by."""
    least, good = mismatches.min(), quantile(mismatches, GOOD)
    return math.sqrt(max(least, MISMATCH_FLOOR) * max(good, MISMATCH_FLOOR))
