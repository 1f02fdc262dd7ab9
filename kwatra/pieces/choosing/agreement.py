"""How well the blocks at all places of an exemplar agree with what is known of a box, in colors or in anything else."""

from collections.abc import Sequence

import numpy as np

from kwatra.base.spans import of_volume
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.fitting import Fit
from kwatra.pieces.choosing.seen import Compared, Seen
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

    @property
    def taken(self) -> tuple[Array, Array]:
        """What is compared, by place (planes, M), and of which image each plane is (planes,)."""
        return self._planes, self._image

    def compared(self, seen: Seen, aligned: bool = True) -> Compared:
        """How blocks compare with what is known of boxes; aligned: False compares nothing.

        What hangs over the exemplar is taken to agree as a fair one of the valid blocks does.
        """
        boxes, images, corners = len(seen.some), len(self._variances), self.corners
        extent = seen.known.shape[-len(corners.block) :]
        how = any(corners.hang), of_volume(corners.seen(extent)), FAIR, self._variances, 10.0**DIGITS
        if not aligned:
            nothing: Array = np.empty((0, images, corners.valid.size))
            return Compared(nothing, seen.against, nothing, *how)
        raw = corners.on_grain(self.fit.less_energy(seen.ones.reshape(*seen.ones.shape[:2], *extent)))
        inside = self._inside(seen.against.reshape(boxes, images + 1, *extent))
        return Compared(np.ascontiguousarray(raw).reshape(boxes, images, -1), seen.against, inside, *how)

    def _inside(self, against: Array) -> Array:
        """The sums (b, m, n) of what is compared with (b, m, *E) over what each block shows, if holes say what.

        None of boxes, (0, m, n), if nothing but a border does.
        """
        count = self.corners.valid.size
        if self.corners.holes is None:
            return np.empty((0, against.shape[1], count))
        hidden = self.corners.hidden(against.reshape(-1, *against.shape[2:])).reshape(*against.shape[:2], count)
        return np.maximum(against.sum(tuple(range(2, against.ndim)))[..., None] - hidden, 0)
