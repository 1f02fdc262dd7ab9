"""Which blocks of the exemplar are tried in a box: for what agrees with what lies there, and was little used so far."""

import math
from collections.abc import Sequence
from copy import copy
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage

from kwatra.base.axes import AXES
from kwatra.base.spans import in_volume, of_volume, volume
from kwatra.elements import Lattice, Rows
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing.agreement import Agreement
from kwatra.pieces.choosing.charges import NEAR, StepCosts, around, charged
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.seen import Charges, Seen
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

TRIED = 0.5
"""Where gaps hide seams so many of the blocks are tried that are else: cuts cost more time there, and differ less. Of
36 stills of six kinds of elements, 20 and 30 px, .078 are cut, .074 with 1; of 48 others .074 with .34, .070 with 1,
which is within what seeds differ by. Ten photographs score .0552, .0554 with 1; a wall takes 1.6 s, not 2.0."""

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
    each place others that show the same (`kwatra.pieces.choosing.twins`). strict: whether none are laid that are out of
    step.
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
    strict: bool


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
        self.steps = None if asked.repeats is None else StepCosts(asked.repeats, *lines, exactly=asked.strict)

    def on(self, sheet: Sheet[Mosaic]) -> "Candidates":
        """The same for boxes of another sheet of the same mosaic."""
        other = copy(self)
        other.sheet = sheet
        return other

    def choose(
        self,
        boxes: Sequence[Box],
        needed: Array | None,
        used: Array,
        most: int,
        luck: Sequence[float],
        rest: bool = False,
    ) -> Chosen:
        """For each of boxes of one extent at most so many blocks.

        needed (b, *E): the pixels that a block has to fill if they are empty; None for none. used (*cell): how often
        each place of the mosaic was. Where there is no seam to compare, or a wish decides, one block of about the least
        cost is drawn: luck (b,), 0 to 1, says which, and what else blocks cost if luck decides on that (`Asked`).
        Memory is that of a few arrays of the exemplar's size for each box. rest: whether a block has to be laid, though
        it be out of step.

        Blocks cost less where they agree with what is known of boxes, in what agreement this texture affords: rows that
        can line up are not torn for the sake of even use. They cost more for where in the exemplar they come from, for
        what was shown before, and where they are out of step.
        """
        from kwatra.pieces.choosing.weighing import weigh

        seen = self._seen(boxes, needed)
        compared = self.agreement.compared(seen, self.asked.aligned)
        some = seen.some if self.steps is None else seen.some | bool(self.sheet.patches)
        charges = self._charges(boxes, seen, some, used, luck, self.asked.strict and not rest)
        gaps, at_most = 0.0 if self._gaps is None else self._gaps.weight, self._at_most(boxes, seen.some, most)
        costs, picked = np.empty(seen.same.shape), np.empty((len(boxes), max(at_most)), np.int64)
        weigh(
            compared, charges, seen.valid, seen.same, some, GOOD, MISMATCH_FLOOR, gaps, at_most, ACCEPTABLE, TOLERANCE,
            np.array(luck), costs, picked,
        )  # fmt: skip
        chosen = picked >= 0
        box, numbers = chosen.nonzero()[0], picked[chosen]
        firsts = np.zeros(len(boxes) + 1, np.int64)
        chosen.sum(1).cumsum(out=firsts[1:])
        return Chosen(firsts, self.corners.at(numbers), costs[box, numbers])

    def _at_most(self, boxes: Sequence[Box], some: Array, most: int) -> Array:
        """How many blocks are tried in each box, at most so many where `some` (b,) of it is known."""
        wish = self._deciding
        if not self.asked.aligned:
            return np.ones(len(boxes), np.int64)
        if self._gaps is not None:
            most = math.ceil(TRIED * most)
        if wish is not None:
            some = some & ~np.array([wish.anything(self.sheet.indices(box)) for box in boxes])
        return np.where(some, most, 1)

    def _seen(self, boxes: Sequence[Box], needed: Array | None) -> Seen:
        """What is known of boxes of one extent; needed: as in `choose`."""
        from kwatra.pieces.choosing.comparing import see

        corners, (planes, images) = self.corners, self.agreement.taken
        count, extent, axes = len(boxes), boxes[0].extent, len(self.sheet.shape)
        blocks, pixels = corners.valid.size, math.prod(extent)
        shape = count, *(1,) * (AXES - axes), *extent
        against = np.empty((count, len(self.agreement.fit.images) + 1, *shape[1:]))
        seen = Seen(
            np.empty(shape, self.sheet.places.dtype), np.empty(shape, bool), np.empty(count, bool),
            np.empty(count, np.int64), np.empty((count, len(planes) + 1, pixels), np.float32), against,
            np.empty((count, blocks), bool), np.empty((count, blocks)),
        )  # fmt: skip
        on_holes = needed is not None and corners.holes is not None
        inside = np.empty((0, *shape[1:]), bool) if needed is None or on_holes else needed.reshape(shape)
        patches = 0 if self.steps is None else len(self.sheet.patches)
        sheet = volume(self.sheet.label, axes), volume(self.sheet.places[None], axes)
        starts, ends = in_volume([box.start for box in boxes], 0), np.array(extent)
        see(*sheet, starts, ends, inside, patches, corners.frame, planes, images, seen)
        if needed is not None and on_holes:
            missing = needed & ~seen.known.reshape(needed.shape)
            seen.valid[:] = corners.emptying_least(missing).reshape(count, blocks)
        return seen

    def _charges(
        self, boxes: Sequence[Box], seen: Seen, some: Array, used: Array, luck: Sequence[float], only: bool
    ) -> Charges:
        """What blocks cost beside that they disagree, out of step where some (b,) says; the rest is as in `choose`.

        only: whether no others than those in step may be laid.
        """
        asked, corners, (again, beside) = self.asked, self.corners, self._prices
        shape = seen.same.shape
        away: Array = np.empty((len(boxes), 0))
        steps = away
        if asked.places:
            lines = corners.valid.shape, corners.grain, asked.device
            each = [charged(asked.places, box.start, *lines).ravel() for box in boxes]
            away = np.stack(each) / self.variance
        if self.steps is not None:
            steps = np.empty(shape)
            for at in np.flatnonzero(some).tolist():
                steps[at] = self.steps.at(self._from(boxes[at], int(seen.most[at]))).ravel()
        more = [FOLD * self._folded(twin, seen).reshape(shape) for twin in asked.twins]
        if self._luck:
            drawn = [np.random.default_rng(int(one * 2**53)).random(shape[1]) for one in luck]
            more.append(self._luck * np.stack(drawn))
        in_step = 0.0 if self.steps is None else self.steps.in_step
        near = around(self.sheet, boxes if beside > 0 else (), corners, asked.twins)
        return Charges(
            self._missed(boxes), away, volume(used[None], used.ndim), of_volume(corners.under), corners.pixels.ravel(),
            math.prod(corners.shape), asked.usage, near, again, beside, steps, in_step, only,
            np.stack(more) if more else np.empty((0, *shape)),
        )  # fmt: skip

    def _folded(self, twin: Array, seen: Seen) -> Array:
        """How much of a fold blocks make (b, *n), 0 to 1: along how much of a side they meet a twin of what is known.

        A fold is a line along which places are those of twins; they may be a pixel off.
        """
        extent = seen.known.shape[-len(self.corners.block) :]
        places, known = (part.reshape(-1, *extent) for part in (seen.places, seen.known))
        there = twin[places]
        counts = self.corners.continuing(there, known & (there >= 0))
        near = ndimage.uniform_filter(counts, (0, *(3,) * (counts.ndim - 1)), mode="constant") * 3 ** (counts.ndim - 1)
        folded: Array = np.minimum(near / (0.5 * min(self.corners.block)), 1)
        return folded

    def _missed(self, boxes: Sequence[Box]) -> Array:
        """What blocks (b, n) miss of a wish, relative to the variance; of no boxes where nothing is wished for.

        It is a mean square of its own, as how little they agree with what is known: so neither is diluted by the other.
        Weights below 1 scale it.
        """
        wish, missed = self.asked.wish, np.zeros((len(boxes), self.corners.valid.size))
        if wish is None:
            return missed[:0]
        for at, box in enumerate(boxes):
            weight, value, count = wish.at(self.sheet.indices(box))
            if count > 0:
                squared = self.agreement.fit.inside(value.astype(np.float32), weight.astype(np.float32))
                missed[at] = (self.corners.on_grain(squared) / (count * self.variance)).ravel()
        return missed

    def _from(self, box: Box, patch: int) -> list[int]:
        """The offset of the first corner's block in a box, less that of a copy."""
        copied = self.sheet.patches[patch]
        return [b - s + h for b, s, h in zip(box.start, copied.shift, self.corners.hang, strict=True)]
