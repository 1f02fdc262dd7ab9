"""What the optimization starts from: blocks of the exemplar, laid so that they continue each other.

EM only mends what lies within a window's reach, so rows, courses and lattices have to be right before it begins. Blocks
are laid row by row, of large stills from the middle outwards; each is chosen among the exemplar's blocks for how well
it agrees with what already lies under it and with what terms wish for there, and for how little its content has been
used so far (coverage; `Candidates`). Of the best few that is laid whose seam is the cheapest (thesis 3.1): it may run
anywhere within the block, and mend older seams. When all is laid, blocks are laid again where seams cost most (thesis
3.2). Blocks that lie apart are laid at once (`fronts`). Offsets between output and exemplar are multiples of `grain`,
the coarsest level's pixel, so that every level of the pyramid can represent the start exactly. Blocks may hang over the
exemplar's border and lie on its holes (see `Corners`); what they leave empty others fill. What is given of the output
is laid first, and blocks go on from it (`GivenCopies`), elements that it shows a part of are completed (`complete`).

Where there are gaps between elements seams are hidden in them; blocks are chosen also for how well their gaps lie on
those that are there, and are larger and overlap by so much that a seam can go around an element.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from torch import Tensor

from kwatra.base import continued, mean
from kwatra.elements import Lattice, Rows
from kwatra.exemplar import Exemplar
from kwatra.pieces.boxes import Box
from kwatra.pieces.cells import Cells, Fitted, find_cells, fitted
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
from kwatra.pieces.given import BESIDE, NARROW, GivenCopies
from kwatra.pieces.layer import Layer
from kwatra.pieces.offers import Offers
from kwatra.pieces.seams import Gaps, Mosaic, eased, find_gaps
from kwatra.pieces.seams.gaps import LARGEST
from kwatra.pieces.sheet import Sheet
from kwatra.pieces.spread import Spread, overlap_of
from kwatra.terms import PlaceCharge, Wish

FOLLOWING = 0.5, 0.25, 0.125
"""Sizes of the blocks that are laid where others miss a guide, as parts of theirs. Set on what `synth.texture.guidance`
tells of: without the last .972 of five pairs of photographs have their labels where .985 have with it."""

SMALLER = 0.5, 0.25, 0.125
"""Sizes of the blocks that are laid where no others are in step, as parts of theirs: the smaller, the more places they
fit in. Of 64 made pictures of 1.2 to 3 periods of which the lattice is found .0002 is out of step, .09 without them."""

REGULAR = 0.55
"""Of lattices as regular as that blocks make elements whole by themselves. A twill has .93, dots that are moved by 0, 1
and 2 px .72, .66 and .49, three coins in a row by chance .40 and .48."""


class BlockStart:
    """Lays blocks of an exemplar on an output of spatial `shape`; `run` returns the source map (n, *shape).

    block: its size; grain: what offsets are multiples of. wraps: along which axes the output is periodic; None for
    none. usage: what a block costs whose pixels were used once more than all on average. seams: of how many blocks the
    seams are compared. aligned: False takes whole blocks at random. repeats: with which blocks are laid in step, if
    any; with a lattice that is periodic no others are, where neither the output nor the grain hinders it, and no gaps
    are needed to hide seams. along: the axis along which blocks beside each other are out of step, if any; easier: by
    how many times less seams cost along each axis. places: what is charged for where in the exemplar a block comes
    from. wish: values that pixels should have, with weights; a weight of 1 counts fully, as what is laid already. given
    (n, *shape): where in the exemplar's canvas pixels come from that are given and stay, below 0 where none is.

    fitted: once blocks are laid, what is shown where elements were made whole; None where none are. draft: whether
    blocks are laid once only, which tells about how good it is going to be; `refined` is then what `run` makes else.
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
        self.lattice = repeats if isinstance(repeats, Lattice) else None
        self.given = GivenCopies(self.shape, given)
        owned = self.given.owned(exemplar)
        share, colors = exemplar.share.cpu(), continued(exemplar.canvas, owned.owner).cpu()
        middle = torch.stack([mean(channel) for channel in colors]).double().view(share.shape)
        weights = share.double().sqrt()
        self.wish, still = Wished.of(wish, middle, weights), aligned and len(self.shape) == 2
        mosaic = Mosaic([(colors * share).numpy()])
        self.wraps = (False,) * len(self.shape) if wraps is None else tuple(wraps)
        sheet = Sheet(mosaic, self.shape, self.wraps, eased(mosaic, easier))
        self.given.lay(sheet)
        image, var = ((colors - middle) * weights).numpy(), variance(exemplar, self.wish)
        scene = SceneUse.of(image, self.shape) if len(self.shape) > 2 and places else None
        unasked, deviation = unguided(owned, self.wish), var**0.5 / mosaic.step
        self.gaps = find_gaps(unasked, mosaic, deviation) if still and along is None and not self._strict else None
        self.free = still and self.wish is None and not places and bool((exemplar.owner <= 0).all())
        corners, spread, overlap = self._spread_out(sheet, block, along)
        twins, device = twin_places(exemplar, mosaic) if still else NO_TWINS, exemplar.canvas.device
        are = aligned, scene is not None, self.given.any
        asked = Asked(usage, repeats, places, device, self.wish, self.gaps, *are, twins, self._strict)
        candidates = Candidates(sheet, corners, image, var, asked)
        offers, shown = Offers(sheet, image, self.wish, var, min(overlap), not aligned), np.zeros(mosaic.cell)
        self.layer = Layer(exemplar, candidates, offers, spread, overlap, scene, seams, shown, generator)
        self.fitted: Fitted | None = None
        self.draft, self._count = False, 0

    @property
    def sheet(self) -> Sheet[Mosaic]:
        """What blocks are laid on."""
        return self.layer.sheet

    @property
    def _strict(self) -> bool:
        """Whether no block is laid that is out of step: what is periodic goes on so, unless it has to close."""
        return self.lattice is not None and self.lattice.periodic and max(self.grain) == 1 and not any(self.wraps)

    def _spread_out(
        self, sheet: Sheet[Mosaic], block: Sequence[int], along: int | None
    ) -> tuple[Corners, Spread, tuple[int, ...]]:
        """How large blocks are and where they lie in the exemplar, where in the output, and by how much they overlap.

        block: how large they should be. Free ones may lie on holes, or hang over the border where they may lie on any.
        """
        block = tuple(min(b, sheet.longest(axis)) for axis, b in enumerate(block))
        lying = partial(Corners.on_holes, whole=self.gaps is not None) if self.free else Corners.fitting
        corners = lying(self.exemplar, block, self.grain)
        overlap = overlap_of(corners.block)
        if self.gaps is not None:
            sheet.cost = self.gaps.cost
            corners, overlap = self._widened(self.gaps, corners, overlap)
        spread = Spread.over(self.shape, corners.block, overlap, self.grain, self.wraps, along)
        if self.free and (corners.holes is not None or corners.valid.all()):
            needed = (0,) * len(self.shape) if self.gaps is None else overlap
            corners = corners.hanging(spread.overhang(needed))
        return corners, spread, overlap

    def _widened(self, found: Gaps, corners: Corners, overlap: tuple[int, ...]) -> tuple[Corners, tuple[int, ...]]:
        """Blocks that overlap by enough for seams to be hidden in gaps; larger ones where they fit.

        Around an axis that wraps a block meets itself: there it grows to at most half of it. None grows where elements
        stand on a lattice, or tiles would be cut, or where something is wished for everywhere: it would follow less.
        """
        sides = zip(self.exemplar.extent, self.shape, self.wraps, strict=True)
        room = [min(LARGEST * there, size / 2 if wraps else size) for there, size, wraps in sides]
        block, overlap = found.widened(corners.block, overlap, room, self.grain)
        if self.lattice is None and (self.wish is None or not self.wish.everywhere):
            grown = Corners.fitting(self.exemplar, block, self.grain)
            corners = grown if grown.block == block else corners
        return corners, overlap

    def run(self, draft: bool = False) -> Tensor:
        """Lay all blocks, and again where seams cost most; of a draft once only."""
        self.draft = draft
        self._fill()
        return self.where

    @property
    def where(self) -> Tensor:
        """The source map (n, *shape) of what is laid, with elements made whole that nothing steers."""
        return self._laid if self.fitted is None else self.fitted.places.round().long()

    @property
    def _laid(self) -> Tensor:
        """The same as it was laid."""
        places = torch.from_numpy(self.sheet.sources.coordinates(self.sheet.places)[1]).long()
        return self.given.covered(places.to(self.exemplar.canvas.device), self.exemplar.shape)

    @property
    def cells(self) -> Cells | None:
        """Those that are fitted: of a still that nothing steers, where offsets may be any.

        In step elements meet as they stand: fitted, bricks of many lengths become crooked, in lumps of mortar, and four
        stills of a twill score .085 in place of .064. Loose ones need it where they stand there only roughly.
        """
        alone = self.free and self.gaps is not None and max(self.grain) == 1 and not self.given.any
        cells = find_cells(self.exemplar) if alone else None
        if cells is None or self.layer.candidates.steps is None:
            return cells
        roughly = self.lattice is None or self.lattice.regularity < REGULAR
        return cells if cells.loose and roughly else None

    def afresh(self, generator: torch.Generator) -> "BlockStart":
        """Another start, in which all blocks are laid from the beginning; this one stays as it is."""
        other, sheet = copy(self), self.sheet.empty()
        self.given.lay(sheet)
        other.layer = self.layer.on(sheet, np.zeros_like(self.layer.shown), generator)
        other._fill()
        return other

    def refined(self, generator: torch.Generator) -> "BlockStart":
        """What this draft becomes where blocks are laid again; this one stays as it is."""
        other = copy(self)
        other.layer, other.draft = self.layer.on(self.sheet.copy(), self.layer.shown.copy(), generator), False
        other._refine()
        return other

    def anew(self, part: Box, generator: torch.Generator) -> "BlockStart":
        """Another start, in which blocks are laid anew where a part of the output is; this one stays as it is.

        What lies around the part is kept, but for where seams are cheaper further out.
        """
        other, sheet = copy(self), self.sheet.copy()
        sheet.clear(part, self.given.where)
        shown = sheet.sources.counted(self.sheet.places[sheet.filled & ~self.given.where])
        other.layer = self.layer.on(sheet, shown, generator)
        other._fill()
        return other

    def _fill(self) -> None:
        """Lay blocks where nothing lies, first beside what is given; and again, but of a draft."""
        self._go_on()
        boxes = [box for box in self.given.nearest_first(self.layer.boxes) if not self.sheet.full(box)]
        lay = self.layer.lay_all if self.sheet.patches else self.layer.lay_outwards
        lay(boxes)
        self._lay_in_step()
        while rest := [box for box in boxes if not self.sheet.full(box)]:
            self.layer.lay_all(rest, rest=True)
        self._count = len(boxes)
        if not self.draft:
            self._refine()

    def _refine(self) -> None:
        """Lay blocks again where seams cost most, smaller ones where a guide is missed; make elements whole."""
        self.layer.lay_again(self._count)
        if self.wish is not None and self.wish.guided and self.gaps is not None:
            self._follow(self.gaps.hidden.size)
        cells = self.cells
        self.fitted = None if cells is None else fitted(self._laid, cells, self.layer.offers.image, self.wraps)

    def _lay_in_step(self) -> None:
        """Lay smaller and smaller blocks where no larger one is in step with a picture that repeats but for noise."""
        for share in SMALLER if self._strict else ():
            if not self.sheet.filled.all():
                small = self.layer.smaller(share)
                small.lay_all([box for box in small.boxes if not self.sheet.full(box)])

    def _go_on(self) -> None:
        """Complete elements that the border of what is given cuts, and lay small blocks along it."""
        layer = self.layer
        if self.given.any and self.gaps is not None and self.gaps.hidden.parts is None:
            asked = self.gaps.hidden, self.grain, layer.candidates.asked.repeats
            done = complete(self.sheet, self.given, self.exemplar, layer.offers.image, *asked)
            layer.shown += self.sheet.sources.counted(self.sheet.places[done])
        if not self.given.any:
            return
        small = layer.smaller(min(BESIDE, NARROW / min(layer.corners.block[-2:])))
        beside = self.given.beside(small.corners.block, small.overlap, self.grain)
        boxes = [box for box in beside if not self.sheet.full(box)]
        small.lay_all(boxes)
        small.lay_again(len(boxes))
        self.sheet.fixed |= self.given.near(min(small.overlap)) & self.sheet.filled

    def _follow(self, element: float) -> None:
        """Lay smaller blocks where others miss a guide, if that mends more than seams cost; element: its size, px."""
        for share in FOLLOWING:
            small = replace(self.layer.smaller(share), seams=1)
            missing = small.offers.missing(small.boxes, min(small.corners.block) >= element)
            small.lay_all(missing, again=True)
