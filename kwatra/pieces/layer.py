"""Laying blocks of one size on a sheet: those that lie apart at once, and again where seams cost most."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from math import prod

import torch

from kwatra.base import generator_of, shared, threads_shared
from kwatra.exemplar import Exemplar
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing import Candidates, Corners, SceneUse
from kwatra.pieces.fronts import alike, fronts, last_apart, outwards
from kwatra.pieces.offers import Offers
from kwatra.pieces.seams import Array, Mosaic
from kwatra.pieces.sheet import Budget, Offer, Regions, Sheet, cheapest_as_offered, lay_again
from kwatra.pieces.spread import Spread, overlap_of

AGAIN, PATIENCE = 0.3, 6
"""Blocks are laid again at most so often, for each that was laid, and until so many in a row have not helped."""

TOGETHER, LEFT = 8, 4
"""So many blocks are laid again at once, where they lie apart: enough for as many threads. No more are than one of so
many that may still be, for the costliest are not all apart: of six textures, 256x256, ten seeds, seams then cost .919
of what they did before, .927 where all eight are laid at once that may be."""

LOOKED_AT = 2**17
"""So many pixels of the exemplar are looked at together at most, once for each block that is chosen: what is known of
them then stays near the processor."""


@dataclass(eq=False)
class Layer:
    """Lays blocks of an exemplar on a sheet.

    candidates: those that are tried; seams: of so many of them the seams are compared. offers: what these cost. spread:
    where blocks lie in the output; overlap: by how much. scene: what is known of how often a scene is shown. shown
    (*cell): how often each place of the mosaic was.
    """

    exemplar: Exemplar
    candidates: Candidates
    offers: Offers
    spread: Spread
    overlap: tuple[int, ...]
    scene: SceneUse | None
    seams: int
    shown: Array
    generator: torch.Generator

    @property
    def corners(self) -> Corners:
        """Where blocks lie in the exemplar, and how large they are."""
        return self.candidates.corners

    @property
    def sheet(self) -> Sheet[Mosaic]:
        """What blocks are laid on."""
        return self.candidates.sheet

    @property
    def used(self) -> Array:
        """How often each pixel of the exemplar (*S) is shown."""
        return self.shown[(slice(1, -1),) * len(self.sheet.shape)]

    def box(self, corner: Sequence[int]) -> Box:
        """That of the block whose first pixel is at a corner."""
        return Box(tuple(corner), self.corners.block).clipped(self.sheet.shape, self.sheet.periodic)

    @property
    def boxes(self) -> list[Box]:
        """Those of all blocks, row by row."""
        return [self.box(corner) for corner in self.spread.corners]

    def smaller(self, share: float) -> "Layer":
        """What lays blocks of a share of the height and width on the same sheet."""
        *time, height, width = self.corners.block
        size = (*time, *(max(round(share * b), 1) for b in (height, width)))
        corners = Corners.fitting(self.exemplar, size, self.corners.grain)
        overlap = overlap_of(corners.block)
        spread = Spread.over(self.sheet.shape, corners.block, overlap, corners.grain, self.sheet.periodic)
        variance, asked = self.candidates.variance, self.candidates.asked
        candidates = Candidates(self.sheet, corners, self.offers.image, variance, asked)
        offers = replace(self.offers, overlap=min(overlap))
        return replace(self, candidates=candidates, offers=offers, spread=spread, overlap=overlap)

    def on(self, sheet: Sheet[Mosaic], shown: Array, generator: torch.Generator) -> "Layer":
        """What lays the same blocks on another sheet of the same mosaic, given what is shown there."""
        candidates, offers = self.candidates.on(sheet), replace(self.offers, sheet=sheet)
        return replace(self, candidates=candidates, offers=offers, shown=shown, generator=generator)

    def lay_all(self, boxes: Sequence[Box], again: bool = False, rest: bool = False) -> None:
        """Lay blocks in boxes, those that lie apart at once; again and rest: as in `_lay`."""
        luck = iter(self._luck(len(boxes)))
        for front in fronts(boxes, *self._spacing):
            self._lay([boxes[number] for number in front], [*islice(luck, len(front))], again, rest)

    def lay_outwards(self, boxes: Sequence[Box], axis: int = 0) -> None:
        """Lay blocks in boxes of an empty sheet: of a large still in the middle, then on both sides of that at once.

        axis: along which, or along the next one where the still is not large. Neither side counts what the other shows.
        """
        if len(self.sheet.shape) > 2 or axis == 2:
            self.lay_all(boxes)
            return
        parts = None if self.sheet.periodic[axis] else outwards(boxes, axis, self._spacing[0])
        self.lay_outwards(boxes if parts is None else parts.middle, axis + 1)
        if parts is None:
            return
        before, behind = self._aside(backwards=(axis,)), self._aside()
        works = partial(before.lay_all, parts.before), partial(behind.lay_all, parts.behind)
        shared(lambda work: work(), works)
        self.sheet.join(before.sheet, behind.sheet, axis, min(box.start[axis] for box in parts.behind))
        self.shown = before.shown + behind.shown - self.shown

    def _aside(self, backwards: tuple[int, ...] = ()) -> "Layer":
        """What lays the same blocks on the same sheet meanwhile, along some axes from the last to the first."""
        seed = int(torch.randint(2**62, (1,), generator=self.generator))
        aside = self.on(self.sheet.aside(), self.shown.copy(), generator_of(seed))
        return replace(aside, spread=replace(self.spread, backwards=backwards))

    def lay_again(self, count: int) -> None:
        """Lay blocks again where seams cost most, the more often the more of them there are."""
        if self.candidates.asked.aligned:
            half = tuple(max(b // 2, 1) for b in self.corners.block)
            costly = partial(self._costly, Regions(self.sheet, half, self.generator))

            def improve(boxes: Sequence[Box]) -> list[bool]:
                return self._lay(boxes, self._luck(len(boxes)), again=True)

            lay_again(self.sheet, costly, improve, Budget(round(AGAIN * count), PATIENCE))

    @property
    def _spacing(self) -> tuple[int, tuple[int, ...], tuple[bool, ...]]:
        """How far apart boxes lie that are worked on at once, on which grid, and which axes of it wrap.

        They do not touch; of stills, where it counts what is shown nearby, they lie so far apart that none counts.
        """
        return max(self.corners.block) if len(self.sheet.shape) == 2 else 1, self.sheet.shape, self.sheet.periodic

    def _luck(self, count: int) -> list[float]:
        """So many numbers, 0 to 1, drawn at random: to draw a few of them again and again takes as long."""
        drawn: list[float] = torch.rand(count, generator=self.generator, dtype=torch.float64).tolist()
        return drawn

    def _lay(self, boxes: Sequence[Box], luck: Sequence[float], again: bool = False, rest: bool = False) -> list[bool]:
        """Lay blocks in boxes that lie apart; of each whether it was: again one is only where that lowers seams.

        luck: a number for each, 0 to 1, says what is drawn for it. rest: whether they are the last that fill these.

        In each box the block is cut in that costs least with what is seen of its seams. Threads share the boxes, or
        what is tried in one; some boxes of one extent are looked at together, as threads wait between short steps.
        """
        often = None if self.scene is None else self.scene.prices(self.used)
        hang = (0,) * len(self.sheet.shape) if rest else self.corners.hang

        def choose(numbers: Sequence[int]) -> Offer:
            some = [boxes[number] for number in numbers]
            needed = None if again else self.spread.needed(some, hang)
            lucks = [luck[number] for number in numbers]
            chosen = self.candidates.choose(some, needed, self.shown, self.seams, lucks, rest)
            return self.offers.of(self.sheet.windows(some), some, chosen, often, again)

        most = max(LOOKED_AT // prod(self.exemplar.shape), 1)
        groups = alike(boxes, min(most, -(-len(boxes) // threads_shared())))
        cuts = cheapest_as_offered(self.sheet, groups, choose, self.corners.owned)
        laid = {
            number: (group, at)
            for group, (numbers, some) in enumerate(zip(groups, cuts, strict=True))
            for at, (number, patch) in enumerate(zip(numbers, some.patches, strict=True))
            if patch is not None
        }
        self.sheet.commit_each(cuts, [laid[number] for number in sorted(laid)], self.shown)
        return [number in laid for number in range(len(boxes))]

    def _costly(self, regions: Regions, most: int) -> list[Box]:
        """Boxes around the regions whose seams cost most, up to so many that lie apart."""
        boxes, count = list[Box](), min(max(most // LEFT, 1), TOGETHER)
        far = tuple(b + self._spacing[0] for b in self.corners.block)
        for region in regions.costliest_apart(count, far):
            box = self.box(self.spread.around(region, self.sheet.shape, self.sheet.periodic))
            if last_apart([*boxes, box], *self._spacing):  # at a border boxes lie nearer than regions
                regions.rest(region)
                boxes.append(box)
        return boxes
