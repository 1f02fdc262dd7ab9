"""How well the blocks at all places of an exemplar agree with what is known of a box, in colors or in anything else."""

from collections.abc import Sequence

import numpy as np

from kwatra.base.spans import of_volume, volume
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.fitting import Fit
from kwatra.pieces.seams import Array, by_place

FAIR = 0.25
"""What hangs over the exemplar is taken to agree with what is known as well as this share of blocks at least do.

Two panels of 16 textures score .052 and .058 with it, .052 and .059 with .5, and .055 and .065 without overhang."""

DIGITS = 5
"""Disagreement is rounded to so many digits: what agrees equally well stays a tie, whatever the transform rounds."""


class Agreement:
    """Of images (C, *S) that show the same of an exemplar, each for itself, with blocks at `corners`.

    images: with the variances that differences are relative to. Compared in single precision.
    """

    def __init__(self, images: Sequence[tuple[Array, float]], corners: Corners) -> None:
        self.corners, self._variances = corners, np.array([variance for _, variance in images])
        single = [image.astype(np.float32) for image, _ in images]
        self.fit = Fit(*(corners.around(image) for image in single))
        self._planes = np.stack([by_place(plane) for image in single for plane in image])
        self._image = np.repeat(np.arange(len(single)), [len(image) for image in single])

    def mismatch(self, places: Array, known: Array, valid: Array) -> Array:
        """The mean squared difference (b, images, *n) of each block to what is known of boxes, 0 where nothing is.

        places, known (b, *E): where in the exemplar that comes from, in a mosaic of it alone, and where there is any.
        What hangs over the exemplar is taken to agree as a fair one of the `valid` (b, *n) blocks does.
        """
        from kwatra.pieces.choosing.comparing import compare, take_known

        boxes, images, extent = len(known), len(self._variances), known.shape[1:]
        ones = np.empty((boxes, len(self._planes) + 1, *extent), np.float32)
        against = np.empty((boxes, images + 1, *extent))
        there = places.reshape(boxes, -1), known.reshape(boxes, -1)
        take_known(self._planes, self._image, *there, *(part.reshape(*part.shape[:2], -1) for part in (ones, against)))
        raw, mismatch = self.corners.on_grain(self.fit.less_energy(ones)), np.empty((boxes, images, *valid.shape[1:]))
        seen = self._seen(against)
        compare(
            raw.reshape(boxes, images, -1), volume(against, len(extent)), seen.reshape(*seen.shape[:2], raw[0, 0].size),
            any(self.corners.hang), of_volume(self.corners.seen(extent)), valid.reshape(boxes, -1), FAIR,
            self._variances, 10.0**DIGITS, mismatch.reshape(boxes, images, -1),
        )  # fmt: skip
        return mismatch

    def _seen(self, against: Array) -> Array:
        """The sums (b, m, *n) of what is compared with (b, m, *E) over what each block shows, if holes say what.

        None of boxes, (0, m, *n), if nothing but a border does.
        """
        lines = self.corners.valid.shape
        if self.corners.holes is None:
            return np.empty((0, against.shape[1], *lines))
        hidden = self.corners.hidden(against.reshape(-1, *against.shape[2:])).reshape(*against.shape[:2], *lines)
        whole = against.sum(tuple(range(2, against.ndim)))
        return np.maximum(whole.reshape(*whole.shape, *[1] * len(lines)) - hidden, 0)
