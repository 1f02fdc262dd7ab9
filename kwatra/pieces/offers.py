"""What blocks that are tried in a box cost, beside their seams: what laying compares."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing import Chosen, Wished
from kwatra.pieces.seams import Array, Mosaic, each
from kwatra.pieces.sheet import Offer, Patch, Sheet, Windows, patch_of

MISSED, MISSED_BY_MUCH = 0.05, 0.5
"""By how much blocks have to miss a guide that smaller ones are laid there, in variances of what is copied; the second
where these are smaller than an element, for they cut it. Labels are missed by more, what varies smoothly by less: four
made textures that a gradient guides (weight .3) have .34 of their elements cut and are off by .08, .49 and .06 without
the second; of three pairs of textures, labels drawn into a picture of both, .99 of the pixels have theirs with and
without."""


@dataclass(frozen=True, eq=False)
class Offers:
    """Makes offers of blocks for boxes of a sheet.

    image (C, *S): the exemplar's colors, about their mean. wish: what terms wish for, or None. variance: of the colors;
    what is missed of a wish counts in it. overlap: px, how wide the strip is in which a seam runs. must: whether a
    block is laid whatever it costs.
    """

    sheet: Sheet
    image: Array
    wish: Wished | None
    variance: float
    overlap: int
    must: bool

    def of(self, windows: Windows, boxes: Sequence[Box], chosen: Chosen, often: Array | None, again: bool) -> Offer:
        """Blocks that are chosen for boxes, with what they and their seams cost; windows: those of the boxes.

        That is 1 for a seam in plain sight: between unrelated pixels all along the block. Where blocks are laid again
        what counts is that seams cost less, with what a wish adds. often (T, H, W): what is charged for how often
        places of a scene are shown.
        """
        counts, costs, least = np.diff(chosen.firsts), chosen.costs, math.inf
        shifts = np.repeat(np.array([box.start for box in boxes]), counts, 0) - chosen.places
        if again:
            costs, rates, least = np.zeros(len(shifts)), np.ones(len(shifts)), 0.0
        else:
            known = windows.known(boxes, chosen.firsts, shifts, self.sheet.sources.shapes[0])
            rates = 1 / (self.contrast * np.maximum(known / self.overlap, 1.0))  # how long their seams are, about
        taking = list[Array]()
        if self.wish is not None or often is not None:
            of_each = [box for box, count in zip(boxes, counts.tolist(), strict=True) for _ in range(count)]
            patches = [patch_of(box, shift, self.sheet) for box, shift in zip(of_each, shifts.tolist(), strict=True)]
            taking = [self._taking(patch, often) for patch in patches]
        return Offer(windows, boxes, chosen.firsts, shifts, costs, rates, least, must=self.must, taking=taking)

    @property
    def contrast(self) -> float:
        """What a seam costs between two unrelated pixels."""
        mosaic = self.sheet.sources
        assert isinstance(mosaic, Mosaic)
        return 2 * self.variance**0.5 / mosaic.step

    def missing(self, boxes: Iterable[Box], whole: bool) -> list[Box]:
        """The boxes that miss the wish so much that blocks are laid there; whole: whether these hold an element."""
        least = MISSED if whole else MISSED_BY_MUCH
        return [box for box in boxes if self._missed(box) > least]

    def _missed(self, box: Box) -> float:
        """What the pixels of a box miss of the wish, in the mean, in variances."""
        assert self.wish is not None
        at = self.sheet.indices(box)
        shown = self.image[each(self.sheet.sources.coordinates(self.sheet.places[at])[1])]
        return float(self.wish.missed(at, shown, self.variance).mean())

    def _taking(self, patch: Patch, often: Array | None) -> Array:
        """What each pixel of a patch costs more than what it replaces, as seams cost: by wish, and place in a scene."""
        at = self.sheet.indices(patch.box)
        lines = zip(patch.box.start, patch.box.stop, patch.shift, strict=True)
        new = each(np.ix_(*(np.arange(a, b) - s for a, b, s in lines)))
        old = each(self.sheet.sources.coordinates(self.sheet.places[at])[1].clip(0))
        more = 0.0 if often is None else often[new] - often[old]
        if self.wish is not None:
            missed = (self.wish.missed(at, self.image[place], self.variance) for place in (new, old))
            more = more + next(missed) - next(missed)
        return np.rint(more * self.contrast / 2).astype(np.int64)
