"""How well the blocks at all places of an exemplar agree with what is known of a box, in colors or in anything else."""

import math

import numpy as np

from kwatra.pieces.corners import Corners
from kwatra.pieces.fitting import Fit
from kwatra.pieces.mosaic import by_place
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
        self.corners, self.variance = corners, variance
        self.fit = Fit(corners.around(image))
        self._at_places = np.stack([by_place(plane) for plane in image])

    def mismatch(self, places: Array, known: Array, valid: Array) -> Array:
        """The mean squared difference of each block to what is known (*E) of a box, shaped as `corners.valid`.

        places (*E): where in the exemplar that comes from, in a mosaic of it alone. What hangs over the exemplar is
        taken to agree as a fair one of the `valid` blocks does.
        """
        from kwatra.pieces.loops import take_fairly, take_known

        count, content = int(known.sum()), np.empty((len(self._at_places), *known.shape))
        take_known(self._at_places, places.ravel(), known.ravel(), content.reshape(len(content), -1))
        squares, seen = self.corners.squares(self.fit, content, known)
        if any(self.corners.hang):
            summed = np.empty(squares.shape)
            take_fairly(squares.ravel(), seen.ravel(), valid.ravel(), count, FAIR, summed.ravel())
            squares = summed
        mismatch: Array = squares / (count * self.variance)
        return mismatch


def attainable(mismatches: Array) -> float:
    """The disagreement that a texture affords, given that of all blocks in question: what others are measured by."""
    from kwatra.pieces.loops import quantile

    least, good = mismatches.min(), quantile(mismatches, GOOD)
    return math.sqrt(max(least, MISMATCH_FLOOR) * max(good, MISMATCH_FLOOR))
