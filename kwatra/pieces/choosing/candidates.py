"""Which blocks of the exemplar are tried in a box: for what agrees with what lies there, and was little used so far."""

import math
from collections.abc import Sequence
from copy import copy
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage

from kwatra.elements import Lattice, Rows
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing.agreement import DIGITS, Agreement
from kwatra.pieces.choosing.charges import NEAR, StepCosts, charged, shown_near
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.wished import Wished
from kwatra.pieces.seams import Array, Gaps, Mosaic
from kwatra.pieces.sheet import Sheet
from kwatra.terms import PlaceCharge

GOOD = 0.05
"""Cost is counted in the mean (geometric) of the least disagreement and the one this share of blocks stays below. Half
and twice as much, as of ACCEPTABLE, MISMATCH_FLOOR and AGAIN, changes the score of four textures, .043, by .001."""

MISMATCH_FLOOR = 0.05
"""Disagreement, as a mean square relative to the exemplar's variance, that is hardly seen."""

ACCEPTABLE = 0.5
"""Blocks whose cost exceeds the least by more than this are not laid, however good their seam."""

TOLERANCE = 0.05
"""A block is drawn at random from those whose cost exceeds the least by at most this much."""

LUCK = 0.02
"""In a scene made larger each block costs up to so much more, drawn at random: few first blocks are within TOLERANCE
there, and what follows them is determined, so that of smoke half as large again four seeds made two videos. Of any two
of six seeds .04 to .36 is then the same. At the clip's own size seeds differ without, and fish and a waterfall of twice
the frames lose .004 in score with it; with .05 one waterfall of four replays .56 in place of .39."""

CONTINUATION = 0.3
"""What a block costs more when it merely continues the copy that a neighbor began: a new texture, not a larger copy.

Set on sixteen textures, together with what reuse nearby costs: with 0.5 pieces are a sixth smaller, at a score of .0653
in place of .0637."""

CONTINUATION_IN_TIME = 2.0
"""The same for videos, in which a copy that runs on in time is a replay of the exemplar. A waterfall, smoke and a
fountain come out alike with 1 and 4; with .3 the fountain replays .64 of what moves in place of .21. Where some of a
video is given it costs nothing: of detail that passes behind a hole .78 then goes on exactly, .34 with 2."""


FOLD = 1.0
"""What a block costs more that meets its mirror image, or another variant, so that all goes on there as if folded.

With it, and with variants that count as shown nearby, mirrored and turned stones, nuts, radishes and rocks show .11 of
their pixels twice within 72, with neither .16; scores are as before. Three times as much does no more."""


class Asked(NamedTuple):
    """What is asked of blocks beside that they agree.

    usage: what a block costs whose pixels were used once more than all on average. repeats: with which blocks are laid
    in step. places: what is charged for where in the exemplar a block comes from, on a device. wish: what pixels should
    show. gaps: those that are to go on, unless a wish for what is seen itself says everywhere. aligned: False takes
    blocks at random. larger: whether it is a scene made larger. given: whether some of the output is given. twins: for
    each place others that show the same (`kwatra.pieces.choosing.twins`).
    """

    usage: float
    repeats: Lattice | Rows | None
    places: Sequence[PlaceCharge]
    device: torch.device
    wish: Wished | None
    gaps: Gaps | None
    aligned: bool
    larger: bool
    given: bool
    twins: Array


class Chosen(NamedTuple):
    """Blocks (n,) that are tried in boxes (b,), those of one after those of the one before, the cheapest first.

    firsts (b + 1,): which is the first of each box, and how many there are. places (n, axes): of their first pixels;
    costs (n,).
    """

    firsts: Array
    places: Array
    costs: Array


class Candidates:
    """Blocks of an exemplar's image (C, *S) at `corners`, for boxes of a sheet; differences relative to a variance."""

    def __init__(self, sheet: Sheet[Mosaic], corners: Corners, image: Array, variance: float, asked: Asked) -> None:
        self.sheet, self.corners, self.variance, self.asked = sheet, corners, variance, asked
        guided = asked.wish is not None and asked.wish.guided
        self._gaps = asked.gaps if guided or asked.wish is None or not asked.wish.everywhere else None
        self._deciding = None if guided and self._gaps is not None else asked.wish  # without seams that are compared
        depths = [] if self._gaps is None else [(self._gaps.hidden.unlike[None], 1.0)]
        self.agreement = Agreement([(image, variance), *depths], corners)
        still = len(corners.block) == 2
        again = CONTINUATION if still else 0.0 if asked.given else CONTINUATION_IN_TIME
        self._prices = again, NEAR if still and asked.aligned else 0.0
        self._luck = LUCK if asked.larger or asked.given else 0.0
        lines = corners.valid.shape, corners.grain
        self.steps = None if asked.repeats is None else StepCosts(asked.repeats, *lines)

    def on(self, sheet: Sheet[Mosaic]) -> "Candidates":
        """The same for boxes of another sheet of the same mosaic."""
        other = copy(self)
        other.sheet = sheet
        return other

    def worn(self, used: Array) -> Array:
        """What blocks cost (*n) for how often they were used; used (*cell): how often each place of the mosaic was."""
        mean = used.sum() / math.prod(self.corners.shape)
        worn: Array = self.asked.usage * (self.corners.sums(used) / self.corners.pixels - mean)
        return worn

    def choose(
        self, boxes: Sequence[Box], needed: Array | None, worn: Array, most: int, luck: Sequence[float]
    ) -> Chosen:
        """For each of boxes of one extent at most so many blocks.

        needed (b, *E): the pixels that a block has to fill if they are empty; None for none.
        worn (*n): what blocks cost for how often they were used. Where there is no seam to compare, or a wish decides,
        one block of about the least cost is drawn: luck (b,), 0 to 1, says which, and what else blocks cost if luck
        decides on that (`Asked`). Memory is that of a few arrays of the exemplar's size for each box.
        """
        places, known = self.sheet.shown(boxes)
        if needed is None:
            valid = np.repeat(self.corners.valid[None], len(boxes), 0)
        else:
            valid = self.corners.covering(needed, known)
        some = np.asarray(known.reshape(len(boxes), -1).any(1))
        costs = self._costs(boxes, places, known, some, valid, worn)
        if self._luck:
            costs += [self._luck * np.random.default_rng(int(one * 2**53)).random(costs.shape[1]) for one in luck]
        return self._picked(boxes, costs, np.where(some, most, 1), luck)

    def _picked(self, boxes: Sequence[Box], costs: Array, most: Array, luck: Sequence[float]) -> Chosen:
        """For each box at most so many (b,) of the blocks, of which one drawn by luck (b,), given costs (b, n)."""
        from kwatra.pieces.choosing.weighing import pick_each

        wish = self._deciding
        if not self.asked.aligned:
            most = np.ones_like(most)
        elif wish is not None:
            most = np.where([wish.anything(self.sheet.indices(box)) for box in boxes], 1, most)
        picked = np.empty((len(boxes), max(most)), np.int64)
        pick_each(costs, most, ACCEPTABLE, TOLERANCE, np.array(luck), picked)
        some = picked >= 0
        box, numbers = some.nonzero()[0], picked[some]
        firsts = np.zeros(len(boxes) + 1, np.int64)
        some.sum(1).cumsum(out=firsts[1:])
        return Chosen(firsts, self.corners.at(numbers), costs[box, numbers])

    def _costs(
        self, boxes: Sequence[Box], places: Array, known: Array, some: Array, valid: Array, worn: Array
    ) -> Array:
        """What blocks cost (b, n) in boxes, infinite where they are not `valid` (b, *n).

        Less where they agree with what is `known` (b, *E), in what agreement this texture affords: rows that can line
        up are not torn for the sake of even use. More for where in the exemplar they come from, for what was shown
        before, and where they are out of step. places (b, *E): where what is known comes from; some (b,): where
        anything is.
        """
        from kwatra.pieces.choosing.weighing import weigh

        count, again, beside = len(boxes), *self._prices
        found, same = self._disagreement(boxes, places, known, valid), self.corners.continuing(places, known)
        nothing: Array = np.empty((count, 0))
        away = near = steps = nothing
        if self.asked.places:
            lines = valid.shape[1:], self.corners.grain, self.asked.device
            away = np.stack([charged(self.asked.places, box.start, *lines) for box in boxes]) / self.variance
        if beside > 0:
            near = shown_near(self.sheet, boxes, self.corners, self.asked.twins)
        if self.steps is not None:
            steps, some = np.zeros(same.shape), some | bool(self.sheet.patches)
            for at in np.flatnonzero(some).tolist():
                steps[at] = self.steps.at(self._from_most(boxes[at], known[at]))
        gaps = 0.0 if self._gaps is None else self._gaps.weight
        in_step = 0.0 if self.steps is None else self.steps.in_step
        costs = np.empty((count, worn.size))
        valid, same, away, near, steps = (part.reshape(count, -1) for part in (valid, same, away, near, steps))
        weigh(
            found.reshape(*found.shape[:2], -1), valid, same, some, GOOD, MISMATCH_FLOOR, gaps, away, worn.ravel(),
            near, self.corners.pixels.ravel(), again, beside, steps, in_step, costs,
        )  # fmt: skip
        for twin in self.asked.twins:
            costs += FOLD * self._folded(twin, places, known).reshape(costs.shape)
        return costs

    def _folded(self, twin: Array, places: Array, known: Array) -> Array:
        """How much of a fold blocks make (b, *n), 0 to 1: along how much of a side they meet a twin of what is known.

        A fold is a line along which places are those of twins; they may be a pixel off.
        """
        there = twin[places]
        counts = self.corners.continuing(there, known & (there >= 0))
        near = ndimage.uniform_filter(counts, (0, *(3,) * (counts.ndim - 1)), mode="constant") * 3 ** (counts.ndim - 1)
        folded: Array = np.minimum(near / (0.5 * min(self.corners.block)), 1)
        return folded

    def _disagreement(self, boxes: Sequence[Box], places: Array, known: Array, valid: Array) -> Array:
        """How little blocks agree with what is known of boxes, and with a wish, (b, images, *n)."""
        if self.asked.aligned:
            found = self.agreement.mismatch(places, known, valid)
        else:
            found = np.zeros((len(boxes), 1, *valid.shape[1:]))
        if self.asked.wish is not None:
            for at, box in enumerate(boxes):
                found[at, 0] = self._with_wish(self.asked.wish, box, found[at, 0])
        return found

    def _with_wish(self, wish: Wished, box: Box, mismatch: Array) -> Array:
        """How little the blocks (*n) agree with what is known of a box, and with a wish, relative to the variance.

        Each is a mean square of its own, so that neither is diluted by the other; weights below 1 scale the wish's.
        """
        weight, value, count = wish.at(self.sheet.indices(box))
        if count == 0:
            return mismatch
        missed = self.corners.on_grain(self.agreement.fit.inside(value.astype(np.float32), weight.astype(np.float32)))
        return np.round(mismatch + missed / (count * self.variance), DIGITS)

    def _from_most(self, box: Box, known: Array) -> list[int]:
        """The offset of the first corner's block, less that of the copy which most of what is known of a box is.

        Where nothing is known, less that of the first copy.
        """
        label = self.sheet.label[self.sheet.indices(box)][known]
        most = self.sheet.patches[int(np.bincount(label, minlength=1).argmax())]
        return [b - s + h for b, s, h in zip(box.start, most.shift, self.corners.hang, strict=True)]
