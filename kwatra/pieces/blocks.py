"""What the optimization starts from: blocks of the exemplar, laid so that they continue each other.

EM only mends what lies within a window's reach, so rows, courses and lattices have to be right before it begins.
Blocks are laid one after the other; each is chosen among the exemplar's blocks for how well it agrees with what
already lies under it and with what terms wish for there, and for how little its content has been used so far
(coverage). Of the best few that is laid whose seam is the cheapest (thesis 3.1): it may run anywhere within the block,
and mend older seams. When all is laid, blocks are laid again where seams cost most (thesis 3.2). Offsets between output
and exemplar are multiples of `grain`, the coarsest level's pixel, so that every level of the pyramid can represent the
start exactly. Blocks may hang over the exemplar's border, or it would hardly be shown (see `Corners`).

Where there are gaps between elements seams are hidden in them; blocks are chosen also for how well their gaps lie on
those that are there, and are larger and overlap by so much that a seam can go around an element.
"""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
import torch
from torch import Tensor

from kwatra.base import mean, shared
from kwatra.cut import KEEP, MOST
from kwatra.elements import Lattice
from kwatra.exemplar import Exemplar
from kwatra.pieces.again import Budget, lay_again
from kwatra.pieces.agreement import Agreement, attainable
from kwatra.pieces.boxes import Box
from kwatra.pieces.charges import NEAR, charged, kept_in_step, often_shown, shown_near, step_cost, unevenness
from kwatra.pieces.corners import Corners, overhang, spread
from kwatra.pieces.fitting import continued
from kwatra.pieces.gaps import LARGEST, Gaps, gaps
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.regions import Regions
from kwatra.pieces.seams import SeamCost
from kwatra.pieces.sheet import Cut, Patch, Sheet, Window, each
from kwatra.pieces.stock import Array
from kwatra.pieces.wished import Wished, variance
from kwatra.terms import PlaceCharge, Wish

ACCEPTABLE = 0.5
"""Blocks whose cost exceeds the least by more than this are not laid, however good their seam."""

TOLERANCE = 0.05
"""A block is drawn at random from those whose cost exceeds the least by at most this much."""

CONTINUATION = 0.3
"""What a block costs more when it merely continues the copy that a neighbor began: a new texture, not a larger copy.

Set on sixteen textures, together with what reuse nearby costs: with 0.5 pieces are a sixth smaller, at a score of .0653
in place of .0637."""

CONTINUATION_IN_TIME = 2.0
"""The same for videos, in which a copy that runs on in time is a replay of the exemplar. A waterfall, smoke and a
fountain come out alike with 1 and 4; with .3 the fountain replays .64 of what moves in place of .21."""

OVERLAP = 0.25
"""The part of a block that lies on those before it: within it the seam is free to run. Eight photographs score .051
with it and with .15, which lays as many blocks, and .058 with .35, which lays more."""

AGAIN, PATIENCE = 0.3, 6
"""Blocks are laid again at most so often, for each that was laid, and until so many in a row have not helped."""

Chosen = tuple[tuple[int, ...], float]
"""The corner of a block in the exemplar, and what it costs."""


class BlockStart:
    """Lays blocks of an exemplar on an output of spatial `shape`; `run` returns the source map (n, *shape).

    block: its size; grain: what offsets are multiples of. wraps: along which axes the output is periodic; None for
    none. usage: what a block costs whose pixels were used once more than all on average. seams: of how many blocks the
    seams are compared. aligned: False takes whole blocks at random. lattice: on which elements stand, if they do.
    places: what is charged for where in the exemplar a block comes from. wish: values that pixels should have, with
    weights; a weight of 1 counts fully, as what is laid already.
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
        lattice: Lattice | None = None,
        places: Sequence[PlaceCharge] = (),
        wish: Wish | None = None,
    ) -> None:
        self.exemplar, self.shape, self.grain = exemplar, tuple(shape), tuple(grain)
        self.generator, self.usage, self.seams, self.aligned = generator, usage, seams, aligned
        self.lattice, self.places = lattice, places
        self.continuation = CONTINUATION if len(self.shape) == 2 else CONTINUATION_IN_TIME
        share, colors = exemplar.share.cpu(), continued(exemplar)
        mosaic = Mosaic([(colors * share).numpy()])
        self.wraps = (False,) * len(self.shape) if wraps is None else tuple(wraps)
        self.sheet = Sheet(mosaic, self.shape, self.wraps, SeamCost(mosaic))
        block = tuple(min(b, self.sheet.longest(axis)) for axis, b in enumerate(block))
        self.corners = Corners.fitting(exemplar, block, self.grain)
        self.overlap = tuple(max(round(b * OVERLAP), 1) for b in self.corners.block)
        middle = torch.stack([mean(channel) for channel in colors]).double().view(share.shape)
        weights = share.double().sqrt()
        self.image = ((colors - middle) * weights).numpy()
        self.used, self.laid = np.zeros(exemplar.shape), 0
        self.wish = Wished.of(wish, middle, weights)
        self.variance = variance(exemplar, self.wish)
        self.contrast = 2 * self.variance**0.5 / mosaic.step
        self.uneven = unevenness(self.shape, exemplar.shape[-2:]) if len(self.shape) > 2 and places else 0.0
        heeded = aligned and self.wish is None and len(self.shape) == 2
        self.gaps = gaps(exemplar, mosaic, self.contrast / 2) if heeded else None
        if self.gaps is not None:
            self._heed(self.gaps)
        self.starts = spread(self.shape, self.corners.block, self.overlap, self.grain, self.wraps)
        if heeded and not places and bool((exemplar.owner == 0).all()):
            needed = (0,) * len(self.shape) if self.gaps is None else self.overlap
            self.corners = self.corners.hanging(overhang(self.starts, self.corners.block, needed, self.grain))
        self.colors = Agreement(self.image, self.corners, self.variance)
        self.depths = None if self.gaps is None else Agreement(self.gaps.depth[None], self.corners, 1.0)

    def _heed(self, found: Gaps) -> None:
        """Have seams hidden in gaps, and blocks overlap by enough for that; larger ones where they fit.

        Around an axis that wraps a block meets itself: there it grows to at most half of it. Where elements stand on a
        lattice, which keeps copies in step, none grows: tiles would be cut.
        """
        self.sheet.cost = found.cost
        sides = zip(self.exemplar.extent, self.shape, self.wraps, strict=True)
        room = [min(LARGEST * there, size / 2 if wraps else size) for there, size, wraps in sides]
        block, self.overlap = found.widened(self.corners.block, self.overlap, room, self.grain)
        if self.lattice is None:
            grown = Corners.fitting(self.exemplar, block, self.grain)
            self.corners = grown if grown.block == block else self.corners

    def run(self) -> Tensor:
        """Lay all blocks, row by row, and again where seams cost most."""
        block = self.corners.block
        for corner in product(*self.starts):
            box = Box(corner, block).clipped(self.shape, self.sheet.periodic)
            cut = self._cheapest(box, self._choose(box, self._needed(box)))
            assert cut is not None
            self._commit(cut)
            self.laid += 1
        if self.aligned:
            regions = Regions(self.sheet, tuple(max(b // 2, 1) for b in block), self.generator)
            lay_again(self.sheet, regions, self._improve, Budget(round(AGAIN * self.laid), PATIENCE))
        where = self.sheet.sources.coordinates(self.sheet.places)[1]
        return torch.from_numpy(where).long().to(self.exemplar.canvas.device)

    def _needed(self, box: Box) -> Array:
        """Which pixels of a box a block has to fill: empty ones, but for where it may hang over towards later blocks.

        That is by half of the overhang, so that something is known under those.
        """
        needed = ~self.sheet.filled_at(self.sheet.indices(box))
        for axis, (hang, starts) in enumerate(zip(self.corners.hang, self.starts, strict=True)):
            if box.start[axis] != starts[-1]:
                needed.swapaxes(0, axis)[box.extent[axis] - hang // 2 :] = False
        return needed

    def _improve(self, region: Box) -> bool:
        """Lay a block around a region if that lowers the seams' cost, and what a wish adds to it."""
        corner = []
        for start, extent, block, size, g, wraps in zip(
            region.start, region.extent, self.corners.block, self.shape, self.grain, self.wraps, strict=True
        ):
            first = round((start - (block - extent) / 2) / g) * g
            corner.append(first if wraps else min(max(first, 0), max(size - block, 0) // g * g))
        box = Box(tuple(corner), self.corners.block).clipped(self.shape, self.sheet.periodic)
        cut = self._cheapest(box, self._choose(box, np.zeros(box.extent, bool)), again=True)
        if cut is None or not cut.take.any():
            return False
        self._commit(cut)
        return True

    def _commit(self, cut: Cut) -> None:
        """Lay a block, and count what is used of the exemplar now."""
        cell = self.sheet.sources.cell
        gone = self.sheet.places[cut.at][cut.take & (self.sheet.label[cut.at] >= 0)]
        new, old = (np.bincount(places, minlength=math.prod(cell)) for places in (cut.places[cut.take], gone))
        self.used += (new - old).reshape(cell)[tuple(slice(1, n + 1) for n in self.used.shape)]
        self.sheet.commit(cut)

    def _choose(self, box: Box, needed: Array) -> list[Chosen]:
        """Corners of blocks to copy, and their costs: good agreement with what is known and wished for, little used.

        needed: the pixels of the box that they have to fill.
        Where there is no seam to compare, or a wish decides, a block of about the least cost is drawn.
        """
        at = self.sheet.indices(box)
        known, places = self.sheet.filled_at(at), self.sheet.places[at]
        valid = self.corners.valid
        if any(self.corners.hang):
            valid = valid & self.corners.covering(needed)
        same = self.corners.continuing(places, known)
        again = same > 0  # what would only continue a copy that is there already
        mismatch = self._mismatch(known, places, at, valid)
        others = valid & ~again
        others = others if others.any() else valid
        away = charged(self.places, box.start, valid.shape, self.grain, self.exemplar.canvas.device)
        # in units of what agreement this texture affords: rows that can line up are not torn for the sake of even use
        cost = (mismatch + away / self.variance) / attainable(mismatch[others])
        if self.gaps is not None and self.depths is not None and known.any():
            apart = self.depths.mismatch(places, known, valid)
            cost = self.gaps.weighed(cost, apart / attainable(apart[others]))
        cost = cost + self._repetition(box, known, at, same, valid)
        flat = np.where(valid, cost, math.inf).ravel()
        wished = self.wish is not None and self.wish.anything(at)
        if self.seams > 1 and self.aligned and known.any() and not wished:
            last = min(self.seams, len(flat)) - 1
            near = np.flatnonzero(flat <= min(np.partition(flat, last)[last], flat.min() + ACCEPTABLE))
            picks = near[flat[near].argsort(kind="stable")][: self.seams]
        else:
            good = np.flatnonzero(flat <= flat.min() + TOLERANCE)
            picks = good[[int(torch.randint(len(good), (1,), generator=self.generator))]]
        return [(corner, float(flat[pick])) for corner, pick in zip(self.corners.at(picks), picks, strict=True)]

    def _repetition(self, box: Box, known: Array, at: tuple[Array, ...], same: Array, valid: Array) -> Array:
        """What blocks cost, shaped as `valid`, for what was shown before, and for leaving the lattice.

        same: how many pixels a block shows where they are shown already: it then continues a copy.
        """
        from kwatra.pieces.loops import charge_shown

        still = self.aligned and len(self.shape) == 2
        near = [shown_near(self.sheet, box, max(self.corners.block), self.used.shape)] if still else []
        sums, shown = self.corners.sums(np.stack([self.used, *near])), np.empty(valid.shape)
        used, beside, again, pixels, cost = (v.ravel() for v in (sums[0], sums[-1], same, self.corners.pixels, shown))
        prices = self.usage, self.continuation, NEAR if still else 0.0
        charge_shown(used, beside, again, pixels, self.used.mean(), *prices, cost)
        if self.lattice is None or not known.any():
            return shown
        # in step with the copy which most of what is known is
        most = self.sheet.patches[int(np.bincount(self.sheet.label[at][known]).argmax())]
        first = [float(b - s + h) for b, s, h in zip(box.start, most.shift, self.corners.hang, strict=True)]
        return kept_in_step(self.lattice, step_cost(self.lattice, first, valid.shape, self.grain), shown, valid)

    def _mismatch(self, known: Array, places: Array, at: tuple[Array, ...], valid: Array) -> Array:
        """How little the blocks at all places agree with what is known, and with the wish, relative to the variance.

        Each is a mean square of its own, so that neither is diluted by the other; weights below 1 scale the wish's.
        """
        some = self.aligned and known.any()
        mismatch = self.colors.mismatch(places, known, valid) if some else np.zeros(valid.shape)
        if self.wish is not None:
            weight, value, count = self.wish.at(at)
            if count > 0:
                missed = self.corners.on_grain(self.colors.fit.inside(value, weight))
                mismatch = mismatch + missed / (count * self.variance)
        return np.round(mismatch, 9)  # what agrees equally well stays a tie, whatever the transform rounds

    def _cheapest(self, box: Box, chosen: Sequence[Chosen], again: bool = False) -> Cut | None:
        """Of blocks cut in along the cheapest seams the one that costs least with what is seen of its seams.

        That is 1 for a seam in plain sight: between unrelated pixels all along the block. Where blocks are laid again
        it is the one that lowers seams most, None if none does. Threads share the blocks; one that turns out to be no
        better than another is not cut in to the end.
        """
        window, found = self.sheet.window(box), list[tuple[float, int, Cut]]()
        often = self.uneven * often_shown(self.used) if self.uneven else None

        def tried(number: int) -> None:
            place, cost = chosen[number]
            shift = tuple(s - p for s, p in zip(box.start, place, strict=True))
            patch = Patch(0, shift, box.within(Box(shift, self.exemplar.shape)))
            cost, rate = (0.0, 1.0) if again else (cost, 1 / (self.contrast * self._length(window, patch)))
            least = min((worth for worth, *_ in found), default=0.0 if again else math.inf)
            most = MOST if least == math.inf else math.ceil((least - cost) / rate)
            must = None if self.aligned else np.ones(patch.box.extent, bool)
            cut = self.sheet.cut_below(most, patch, must=must, taking=self._taking(patch, often), window=window)
            if cut is not None:
                found.append((cost + rate * cut.price, number, cut))

        shared(tried, range(len(chosen)))
        best = min(found, key=lambda one: one[:2], default=None)
        return None if best is None or (again and best[0] >= 0) else best[2]

    def _length(self, window: Window, patch: Patch) -> float:
        """How long the seam of a patch is, about."""
        known = np.count_nonzero(window.kept[window.part(patch.box)] == KEEP)
        return max(known / min(self.overlap), 1.0)

    def _taking(self, patch: Patch, often: Array | None) -> Array | None:
        """What each pixel of a patch costs more than what it replaces, as seams cost: by wish, and place in a scene."""
        if self.wish is None and often is None:
            return None
        at = self.sheet.indices(patch.box)
        lines = zip(patch.box.start, patch.box.stop, patch.shift, strict=True)
        new = each(np.ix_(*(np.arange(a, b) - s for a, b, s in lines)))
        old = each(self.sheet.sources.coordinates(self.sheet.places[at])[1].clip(0))
        more = 0.0 if often is None else often[new] - often[old]
        if self.wish is not None:
            missed = (self.wish.missed(at, self.image[place], self.variance) for place in (new, old))
            more = more + next(missed) - next(missed)
        return np.rint(more * self.contrast / 2).astype(np.int64)
