"""How well the blocks at all places of an exemplar agree with what is known of a box, in colors or in anything else."""

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

DIGITS = 5
"""Disagreement is rounded to so many digits: what agrees equally well stays a tie, whatever the transform rounds."""


class Agreement:
    """Of an image (C, *S) of the exemplar, with blocks at `corners`, relative to a variance; in single precision."""

    def __init__(self, image: Array, corners: Corners, variance: float) -> None:
        self.corners, self.variance, image = corners, variance, image.astype(np.float32)
        self.fit = Fit(corners.around(image))
        self._at_places = np.stack([by_place(plane) for plane in image])

    def mismatch(self, places: Array, known: Array, valid: Array) -> Array:
        """The mean squared difference of each block (b, *n) to what is known (b, *E) of boxes, 0 where nothing is.

        places (b, *E): where in the exemplar that comes from, in a mosaic of it alone. What hangs over the exemplar is
        taken to agree as a fair one of the `valid` (b, *n) blocks does.
        """
        from kwatra.pieces.weighing import compare, take_known

        boxes, channels, extent = len(known), len(self._at_places), known.shape[1:]
        ones, against = np.empty((boxes, channels + 1, *extent), np.float32), np.empty((boxes, 2, *extent))
        pixels = (values.reshape(boxes, -1) for values in (places, known))
        take_known(self._at_places, *pixels, *(values.reshape(*values.shape[:2], -1) for values in (ones, against)))
        raw, mismatch = self.corners.on_grain(self.fit.less_energy(ones)), np.empty(valid.shape)
        hangs = any(self.corners.hang)
        inside = self.corners.inside(against) if hangs else np.empty((boxes, 2, 0))
        flat = against.reshape(boxes, 2, -1), inside.reshape(boxes, 2, -1), valid.reshape(boxes, -1)
        units = self.variance, 10.0**DIGITS
        compare(raw.reshape(boxes, -1), *flat, FAIR, *units, mismatch.reshape(boxes, -1))
        return mismatch


def attainable(mismatches: Array, valid: Array, same: Array) -> Array:
    """The disagreement (b,) that a texture affords, given that of all blocks (b, *n): what others are measured by.

    It is that of `valid` ones that do not merely continue what is there (`same` is 0), or else of all valid ones.
    """
    from kwatra.pieces.weighing import attain

    boxes, afforded = len(valid), np.empty(len(valid))
    flat = mismatches.reshape(boxes, -1), valid.reshape(boxes, -1), same.reshape(boxes, -1)
    attain(*flat, GOOD, MISMATCH_FLOOR, afforded)
    return afforded
