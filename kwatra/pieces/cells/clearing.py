"""Loose elements that were drawn anew, on ground as it was; what else is seen of elements there is cleared.

That leaves holes. Each is filled with the exemplar's ground, from where that agrees best with what lies around the hole
and shows the fewest elements; what these would cover is a smaller hole, and is filled next.
"""

import numpy as np
from scipy import ndimage

from kwatra.pieces.cells.shapes import Cells
from kwatra.pieces.choosing import Fit, totals
from kwatra.pieces.seams import Array

RIM = 2
"""So many pixels of their own ground stay around elements. Not tuned."""

AROUND = 4
"""Holes are compared with what is known so many pixels around them. Not tuned."""

TIMES = 4
"""They are filled so often, at most: then little is left, which shows what is next to it. Not tuned."""

COVERED = 4.0
"""What it costs if elements cover all of a hole, in variances of the ground. By eye, on buttons on cloth."""


def seen_of(drawn: Array, written: Array, cells: Cells) -> Array:
    """Where (H, W) elements are seen, and a rim of their ground, of places (2, H, W) that are written (H, W)."""
    seen: Array = ndimage.binary_dilation(written & cells.shows_element(drawn), iterations=RIM) & written
    return seen


def cleared(where: Array, drawn: Array, written: Array, stays: Array, cells: Cells, image: Array) -> Array:
    """Places (2, H, W), float64, with drawn elements on ground as it was laid, and no others but for those that stay.

    where, drawn (2, H, W): places as they were laid, and with elements drawn where they are written (H, W). stays
    (H, W): what stays as it was laid. image (C, *S): the colors of the exemplar's canvas. Memory is that of some
    arrays of the output's size, and a few of the canvas's.
    """
    shown = seen_of(drawn, written, cells)
    other, done = cells.shows_element(where), shown | stays
    left = ndimage.binary_dilation(other & ~done) & ~done
    made = np.where(shown, drawn, where)
    _Filling(made, ~(left | shown | other), left, cells.ground, image).run()
    return made


class _Filling:
    """Sets places (2, H, W) that are left (H, W) to ground (*S) of an image (C, *S), beside what is known (H, W)."""

    def __init__(self, places: Array, known: Array, left: Array, ground: Array, image: Array) -> None:
        self.places, self.known, self.left = places, known, left
        self.ground, self.image = ground, image
        usual = image[:, ground].mean(1) if ground.any() else image.mean((1, 2))
        self.fit = Fit(np.where(ground, image, usual[:, None, None]))  # what elements cover may be anything
        self.colors = image[:, *np.rint(places).astype(np.int64)]
        self.variance = float(image[:, ground].var(1).sum()) if ground.any() else 0.0

    def run(self) -> None:
        """Fill hole by hole; what is left shows what is known nearest."""
        for _ in range(TIMES):
            parts, _ = ndimage.label(self.left, np.ones((3, 3)))
            for number, box in enumerate(ndimage.find_objects(parts), 1):
                wide = tuple(slice(max(s.start - AROUND, 0), s.stop + AROUND) for s in box)
                self._fill(parts[wide] == number, wide)
        if self.left.any() and self.known.any():
            near = ndimage.distance_transform_edt(~self.known, return_distances=False, return_indices=True)
            self.places[:, self.left] = self.places[:, *near[:, self.left]]

    def _fill(self, hole: Array, box: tuple[slice, ...]) -> None:
        """Fill a hole in a box of the output where that shows ground; not if it is larger than the exemplar."""
        if any(size > most for size, most in zip(hole.shape, self.ground.shape, strict=True)):
            return
        around = self.known[box].astype(np.float32)
        differs = self.fit.inside(self.colors[:, *box], around) / max(around.sum() * self.variance, 1e-6)
        covered = np.rint(totals(hole.astype(np.float32), (~self.ground).astype(np.float32)))
        size = np.count_nonzero(hole)
        cost = np.where(covered < size, differs + COVERED * covered / size, np.inf)
        at = np.array(np.unravel_index(cost.argmin(), cost.shape))[:, None]
        pixels = np.argwhere(hole).T
        some = self.ground[*(pixels + at)]
        there, here = (pixels + at)[:, some], (pixels + [[side.start] for side in box])[:, some]
        self.places[:, *here], self.colors[:, *here] = there, self.image[:, *there]
        self.known[*here], self.left[*here] = True, False
