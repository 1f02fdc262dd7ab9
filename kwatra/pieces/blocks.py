"""What the optimization starts from: blocks of the exemplar, laid so that they continue each other.

EM only mends what lies within a window's reach, so rows, courses and lattices have to be right before it begins.
Blocks are laid row by row; each is chosen among the exemplar's blocks for how well it agrees with what already lies
under it and with what terms wish for there, and for how little its content has been used so far (coverage;
`Candidates`). Of the best few that is laid whose seam is the cheapest (thesis 3.1): it may run anywhere within the
block, and mend older seams. When all is laid, blocks are laid again where seams cost most (thesis 3.2). Blocks that lie
apart are laid at once (`fronts`). Offsets between output and exemplar are multiples of `grain`, the coarsest level's
pixel, so that every level of the pyramid can represent the start exactly. Blocks may hang over the exemplar's border
and lie on its holes (see `Corners`); what they leave empty others fill. What is given of the output is laid first, and
blocks go on from it (`GivenCopies`), elements that it shows a part of are completed (`complete`).

Where there are gaps between elements seams are hidden in them; blocks are chosen also for how well their gaps lie on
those that are there, and are larger and overlap by so much that a seam can go around an element.
"""

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np
import torch
from torch import Tensor

from kwatra.base import continued, mean
from kwatra.elements import Lattice, Rows
from kwatra.exemplar import Exemplar
from kwatra.pieces.boxes import Box
from kwatra.pieces.cells import Cells, find_cells, fitted
from kwatra.pieces.choosing import (
    NO_TWINS,
    Asked,
    Candidates,
    Corners,
    SceneUse,
    Wished,
    twin_places,
    unguided,
    variance,
)  # fmt: skip
from kwatra.pieces.completion import complete
from kwatra.pieces.fronts import alike, fronts, last_apart
from kwatra.pieces.given import BESIDE, NARROW, GivenCopies
from kwatra.pieces.offers import Offers
from kwatra.pieces.seams import Array, Gaps, Mosaic, eased, find_gaps
from kwatra.pieces.seams.gaps import LARGEST
from kwatra.pieces.sheet import Budget, Offer, Regions, Sheet, cheapest_as_offered, lay_again
from kwatra.pieces.spread import Spread, overlap_of
from kwatra.terms import PlaceCharge, Wish

AGAIN, PATIENCE = 0.3, 6
"""Blocks are laid again at most so often, for each that was laid, and until so many in a row have not helped."""

FOLLOWING = 0.5, 0.25, 0.125
"""Sizes of the blocks that are laid where others miss a guide, as parts of theirs. Set on what `synth.texture.guidance`
tells of: without the last .972 of five pairs of photographs have their labels where .985 have with it."""

TOGETHER = 8
"""So many blocks at most are laid again at once, where they lie apart: enough for as many threads."""

LOOKED_AT = 2**17
"""So many pixels of the exemplar are looked at together at most, once for each block that is chosen: what is known of
them then stays near the processor."""


class BlockStart:
    """Lays blocks of an exemplar on an output of spatial `shape`; `run` returns the source map (n, *shape).

    block: its size; grain: what offsets are multiples of. wraps: along which axes the output is periodic; None for
    none. usage: what a block costs whose pixels were used once more than all on average. seams: of how many blocks the
    seams are compared. aligned: False takes whole blocks at random. repeats: with which blocks are laid in step, if
    any. along: the axis along which blocks beside each other are out of step, if any; easier: by how many times less
    seams cost along each axis. places: what is charged for where in the exemplar a block comes from. wish: values
    that pixels should have, with weights; a weight of 1 counts fully, as what is laid already. given (n, *shape): where
    in the exemplar's canvas pixels come from that are given and stay, below 0 where none is.
    """

    def __init__(
        self,
        exemplar: Exemplar,
        shape: Sequence[int],
        block: Sequence[int],
        grain: Sequence[int],
        generator: torch.Generator,
        *,
        wraps: Sequence[bool] | None = None,
        usage: float,
        seams: int,
        aligned: bool = True,
        repeats: Lattice | Rows | None = None,
        along: int | None = None,
        easier: Sequence[float] = (1.0, 1.0),
        places: Sequence[PlaceCharge] = (),
        wish: Wish | None = None,
        given: Tensor | None = None,
    ) -> None:
        self.exemplar, self.shape, self.grain = exemplar, tuple(shape), tuple(grain)
        self.generator, self.seams, self.aligned = generator, seams, aligned
        self.lattice = repeats if isinstance(repeats, Lattice) else None
        self.given = GivenCopies(self.shape, given)
        owned = self.given.owned(exemplar)
        share, colors = exemplar.share.cpu(), continued(exemplar.canvas, owned.owner).cpu()
        middle = torch.stack([mean(channel) for channel in colors]).double().view(share.shape)
        weights = share.double().sqrt()
        self.wish, still = Wished.of(wish, middle, weights), aligned and len(self.shape) == 2
        mosaic = Mosaic([(colors * share).numpy()])
        self.wraps = (False,) * len(self.shape) if wraps is None else tuple(wraps)
        self.sheet = Sheet(mosaic, self.shape, self.wraps, eased(mosaic, easier))
        self.given.lay(self.sheet)
        self.image, self.shown = ((colors - middle) * weights).numpy(), np.zeros(mosaic.cell)
        var = variance(exemplar, self.wish)
        self.scene = SceneUse.of(self.image, self.shape) if len(self.shape) > 2 and places else None
        unasked, deviation = unguided(owned, self.wish), var**0.5 / mosaic.step
        self.gaps = find_gaps(unasked, mosaic, deviation) if still and along is None else None
        self.free = still and self.wish is None and not places and bool((exemplar.owner <= 0).all())
        self._spread_out(block, along)
        twins, device = twin_places(exemplar, mosaic) if still else NO_TWINS, exemplar.canvas.device
        are = aligned, self.scene is not None, self.given.any
        asked = Asked(usage, repeats, places, device, self.wish, self.gaps, *are, twins)
        self.candidates = Candidates(self.sheet, self.corners, self.image, var, asked)
        self.offers = Offers(self.sheet, self.image, self.wish, var, min(self.overlap), not aligned)

    @property
    def used(self) -> Array:
        """How often each pixel of the exemplar (*S) is shown."""
        return self.shown[(slice(1, -1),) * len(self.shape)]

    def _spread_out(self, block: Sequence[int], along: int | None) -> None:
        """Settle how large blocks are, by how much they overlap, and where they lie in the exemplar and in the output.

        block: how large they should be. Free ones may lie on holes, or hang over the border where they may lie on any.
        """
        block = tuple(min(b, self.sheet.longest(axis)) for axis, b in enumerate(block))
        lying = partial(Corners.on_holes, whole=self.gaps is not None) if self.free else Corners.fitting
        self.corners = lying(self.exemplar, block, self.grain)
        self.overlap = overlap_of(self.corners.block)
        if self.gaps is not None:
            self._heed(self.gaps)
        self.spread = Spread.over(self.shape, self.corners.block, self.overlap, self.grain, self.wraps, along)
        if self.free and (self.corners.holes is not None or self.corners.valid.all()):
            needed = (0,) * len(self.shape) if self.gaps is None else self.overlap
            self.corners = self.corners.hanging(self.spread.overhang(needed))

    def _heed(self, found: Gaps) -> None:
        """Have seams hidden in gaps, and blocks overlap by enough for that; larger ones where they fit.

        Around an axis that wraps a block meets itself: there it grows to at most half of it. None grows where elements
        stand on a lattice, or tiles would be cut, or where something is wished for everywhere: it would follow less.
        """
        self.sheet.cost = found.cost
        sides = zip(self.exemplar.extent, self.shape, self.wraps, strict=True)
        room = [min(LARGEST * there, size / 2 if wraps else size) for there, size, wraps in sides]
        block, self.overlap = found.widened(self.corners.block, self.overlap, room, self.grain)
        if self.lattice is None and (self.wish is None or not self.wish.everywhere):
            grown = Corners.fitting(self.exemplar, block, self.grain)
            self.corners = grown if grown.block == block else self.corners

    def run(self) -> Tensor:
        """Lay all blocks, row by row, and again where seams cost most."""
        self._fill()
        return self.where

    @property
    def where(self) -> Tensor:
        """The source map (n, *shape) of what is laid, with elements made whole that nothing steers."""
        places = torch.from_numpy(self.sheet.sources.coordinates(self.sheet.places)[1]).long()
        where = self.given.covered(places.to(self.exemplar.canvas.device), self.exemplar.shape)
        cells = self.cells
        return where if cells is None else fitted(where, cells, self.wraps)

    @property
    def cells(self) -> Cells | None:
        """Those that are fitted: of a still that nothing steers, where offsets may be any."""
        alone = self.free and self.gaps is not None and max(self.grain) == 1 and not self.given.any
        return find_cells(self.exemplar) if alone else None

    def anew(self, part: Box, generator: torch.Generator) -> "BlockStart":
        """Another start, in which blocks are laid anew where a part of the output is; this one stays as it is.

        What lies around the part is kept, but for where seams are cheaper further out.
        """
        other = copy(self)
        other.generator, other.sheet = generator, self.sheet.copy()
        other.sheet.clear(part, self.given.where)
        other.shown = self.sheet.sources.counted(self.sheet.places[other.sheet.filled & ~self.given.where])
        other.candidates, other.offers = self.candidates.on(other.sheet), replace(self.offers, sheet=other.sheet)
        other._fill()
        return other

    def _fill(self) -> None:
        """Lay blocks where nothing lies, first beside what is given, then row by row; again where seams cost most."""
        self._go_on()
        in_turn = self.given.nearest_first(map(self.box, self.spread.corners))
        boxes = [box for box in in_turn if not self.sheet.full(box)]
        self._lay_all(boxes)
        while rest := [box for box in boxes if not self.sheet.full(box)]:
            self._lay_all(rest, rest=True)
        self._lay_again(len(boxes))
        if self.wish is not None and self.wish.guided and self.gaps is not None:
            self._follow(self.gaps.hidden.size)

    def smaller(self, share: float) -> "BlockStart":
        """What lays blocks of a share of the height and width on the same sheet."""
        small, candidates, (*time, height, width) = copy(self), self.candidates, self.corners.block
        size = (*time, *(max(round(share * b), 1) for b in (height, width)))
        small.corners = Corners.fitting(self.exemplar, size, self.grain)
        small.overlap = overlap_of(small.corners.block)
        small.spread = Spread.over(self.shape, small.corners.block, small.overlap, self.grain, self.wraps)
        small.candidates = Candidates(self.sheet, small.corners, self.image, candidates.variance, candidates.asked)
        small.offers = replace(self.offers, overlap=min(small.overlap))
        return small

    def _go_on(self) -> None:
        """Complete elements that the border of what is given cuts, and lay small blocks along it."""
        if self.given.any and self.gaps is not None and self.gaps.hidden.parts is None:
            asked = self.gaps.hidden, self.grain, self.candidates.asked.repeats
            done = complete(self.sheet, self.given, self.exemplar, self.image, *asked)
            self.shown += self.sheet.sources.counted(self.sheet.places[done])
        if not self.given.any:
            return
        small = self.smaller(min(BESIDE, NARROW / min(self.corners.block[-2:])))
        beside = self.given.beside(small.corners.block, small.overlap, self.grain)
        boxes = [box for box in beside if not self.sheet.full(box)]
        small._lay_all(boxes)
        small._lay_again(len(boxes))
        self.sheet.fixed |= self.given.near(min(small.overlap)) & self.sheet.filled

    def _follow(self, element: float) -> None:
        """Lay smaller blocks where others miss a guide, if that mends more than seams cost; element: its size, px."""
        for share in FOLLOWING:
            small = self.smaller(share)
            small.seams, boxes = 1, map(small.box, small.spread.corners)
            small._lay_all(self.offers.missing(boxes, min(small.corners.block) >= element), again=True)

    def _lay_all(self, boxes: Sequence[Box], again: bool = False, rest: bool = False) -> None:
        """Lay blocks in boxes, those that lie apart at once; again and rest: as in `_lay`."""
        for front in fronts(boxes, *self._spacing):
            self._lay([boxes[number] for number in front], again, rest)

    def _lay_again(self, count: int) -> None:
        """Lay blocks again where seams cost most, the more often the more of them there are."""
        if self.aligned:
            half = tuple(max(b // 2, 1) for b in self.corners.block)
            costly = partial(self._costly, Regions(self.sheet, half, self.generator))
            lay_again(self.sheet, costly, partial(self._lay, again=True), Budget(round(AGAIN * count), PATIENCE))

    def box(self, corner: Sequence[int]) -> Box:
        """That of the block whose first pixel is at a corner."""
        return Box(tuple(corner), self.corners.block).clipped(self.shape, self.sheet.periodic)

    @property
    def _spacing(self) -> tuple[int, tuple[int, ...], tuple[bool, ...]]:
        """How far apart boxes lie that are worked on at once, on which grid, and which axes of it wrap.

        They do not touch; of stills, where it counts what is shown nearby, they lie so far apart that none counts.
        """
        return max(self.corners.block) if len(self.shape) == 2 else 1, self.shape, self.sheet.periodic

    def _lay(self, boxes: Sequence[Box], again: bool = False, rest: bool = False) -> list[bool]:
        """Lay blocks in boxes that lie apart; of each whether it was: again one is only where that lowers seams.

        rest: whether they are the last that fill these.

        In each box the block is cut in that costs least with what is seen of its seams. Threads share the boxes, or
        what is tried in one; some boxes of one extent are looked at together, as threads wait between short steps.
        """
        luck = torch.rand(len(boxes), generator=self.generator, dtype=torch.float64).tolist()
        often = None if self.scene is None else self.scene.prices(self.used)
        worn, hang = self.candidates.worn(self.shown), (0,) * len(self.shape) if rest else self.corners.hang

        def choose(numbers: Sequence[int]) -> list[Offer]:
            some = [boxes[number] for number in numbers]
            needed = None if again else self.spread.needed(some, hang)
            chosen = self.candidates.choose(some, needed, worn, self.seams, [luck[number] for number in numbers])
            seen = zip(self.sheet.windows(some), some, chosen, strict=True)
            return [self.offers.of(window, box, *tried, often, again) for window, box, tried in seen]

        most = max(LOOKED_AT // math.prod(self.exemplar.shape), 1)
        groups = alike(boxes, min(most, -(-len(boxes) // torch.get_num_threads())))
        found = cheapest_as_offered(self.sheet, groups, choose, self.corners.owned)
        cuts = dict(zip(chain(*groups), found, strict=True))
        for number in range(len(boxes)):
            if (cut := cuts[number]) is not None:
                cut.window.recount(cut.take, cut.places, self.shown)
                self.sheet.commit(cut)
        return [cuts[number] is not None for number in range(len(boxes))]

    def _costly(self, regions: Regions, most: int) -> list[Box]:
        """Boxes around the regions whose seams cost most, up to so many: until one is near another."""
        boxes = list[Box]()
        while len(boxes) < min(most, TOGETHER) and (region := regions.costliest()) is not None:
            box = self.box(self.spread.around(region, self.shape, self.wraps))
            if not last_apart([*boxes, box], *self._spacing):
                break
            regions.rest(region)
            boxes.append(box)
        return boxes
