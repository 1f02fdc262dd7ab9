"""What the optimization starts from: blocks of the exemplar, laid so that they continue each other.

EM only mends what lies within a window's reach, so rows, courses and lattices have to be right before it begins.
Blocks are laid one after the other; each is chosen among the exemplar's blocks for how well it agrees with what
already lies under it and with what terms wish for there, and for how little its content has been used so far
(coverage). All are correlations of the exemplar with the block's known pixels. The seam between old and new is a
minimum cut (thesis 3.1). Offsets between output and exemplar are multiples of `grain`, the coarsest level's pixel, so
that every level of the pyramid can represent the start exactly.
"""

import math
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import AVERAGE, CONVOLUTION, InputError, mean, total
from kwatra.cut import FREE, KEEP, TAKE, along, best_cut, seams_after
from kwatra.exemplar import Exemplar
from kwatra.terms import Wish

COST_LEVELS = 1000
"""Seam costs are counted in this many steps of the color range: minimum cuts are found in whole numbers."""

GOOD = 0.05
"""Cost is counted in the mean (geometric) of the least disagreement and the one this share of blocks stays below."""

ACCEPTABLE = 0.5
"""Blocks whose cost exceeds the least by more than this are not laid, however good their seam."""

TOLERANCE = 0.05
"""A block is drawn at random from those whose cost exceeds the least by at most this much."""

CONTINUATION = 0.5
"""What a block costs more when it merely continues the copy that a neighbor began: a new texture, not a larger copy."""

MISMATCH_FLOOR = 0.05
"""Disagreement, as a mean square relative to the exemplar's variance, that is hardly seen."""


def block_size(exemplar: Exemplar, shape: Sequence[int], share: float, grain: Sequence[int]) -> tuple[int, ...]:
    """Size of the blocks: `share` of the exemplar's extent, at most half of the output, a multiple of grain."""
    size = []
    for there, here, g in zip(exemplar.extent, shape, grain, strict=True):
        wanted = min(share * there, here / 2)
        size.append(min(max(round(wanted / g) * g, g), there // g * g or there))
    return tuple(size)


class _Cut(NamedTuple):
    """A block's corner, which pixels of its place it takes, and its cost with the seam's: 1 for one that is in plain
    sight, two unrelated pixels side by side all along.
    """

    there: list[int]
    fresh: Tensor
    cost: float


class BlockStart:
    """Lays blocks of an exemplar on an output of spatial `shape`; `run` returns the source map (n, *shape).

    wish: values that pixels should have, with weights; a weight of 1 counts fully, as what is laid already.
    """

    def __init__(
        self,
        exemplar: Exemplar,
        shape: Sequence[int],
        block: Sequence[int],
        grain: Sequence[int],
        generator: torch.Generator,
        *,
        wrap: bool = False,
        usage: float = 0.35,
        aligned: bool = True,
        seams: int = 1,
        wish: Wish | None = None,
    ) -> None:
        self.exemplar, self.shape, self.wrap = exemplar, tuple(shape), wrap
        self.grain, self.generator, self.usage, self.aligned, self.seams = (
            tuple(grain),
            generator,
            usage,
            aligned,
            seams,
        )
        self.wish = wish if wish is not None and bool((wish.weight > 0).any()) else None
        self.block, self.valid = self._that_fits(tuple(block))
        self.overlap = tuple(max(b // 4, 1) for b in self.block)
        device = exemplar.canvas.device
        self.x = torch.zeros(len(exemplar.weights), *self.shape, device=device)
        self.known = torch.zeros(self.shape, device=device)
        self.where = torch.zeros(len(self.shape), *self.shape, dtype=torch.long, device=device)
        self.used = torch.zeros(exemplar.shape, device=device)
        self.laid: list[tuple[tuple[int, ...], list[int]]] = []
        self.share = exemplar.share
        self.weighted = exemplar.canvas * self.share
        self.square = (self.weighted * exemplar.canvas).sum(0)
        variance = exemplar.variances * self.share.flatten()
        if self.wish is not None:  # guidance says where a texture goes, not what it looks like
            guided = (self.wish.weight > 0).flatten(1).all(1)
            variance = variance[~guided] if not bool(guided.all()) else variance
        self.variance = max(float(total(variance)), 1e-8)

    def _that_fits(self, block: tuple[int, ...]) -> tuple[tuple[int, ...], Tensor]:
        """The block, halved until it fits between the exemplar's holes, and where it may start (on the grain)."""
        every = tuple(slice(None, None, g) for g in self.grain)
        while True:
            valid = self.exemplar.corners(block)[every]
            if bool(valid.any()):
                return block, valid
            if all(b <= 2 for b in block):
                raise InputError("the exemplar has no free 2x2 block; its mask leaves too little to copy from")
            block = tuple(max(b // 2, 2) for b in block)

    def run(self) -> Tensor:
        """Lay all blocks, row by row."""
        for corner in product(*(self._starts(axis) for axis in range(len(self.shape)))):
            self._lay(corner)
        return self.where

    def _starts(self, axis: int) -> list[int]:
        """Where blocks start along an axis: evenly spread on the grain, overlapping by `overlap` or more."""
        size, block, g = self.shape[axis], self.block[axis], self.grain[axis]
        stride = max(block - self.overlap[axis], 1)
        if self.wrap:
            count = -(-size // stride)
            return sorted({round(i * size / count / g) * g for i in range(count)})
        count = max(-(-(size - block) // stride), 0) + 1
        spread = (size - block) / max(count - 1, 1)
        starts = {math.ceil(i * spread / g) * g for i in range(count)}
        return sorted(s for s in starts if s < size)

    def _lay(self, corner: tuple[int, ...]) -> None:
        """Choose a block for the place at `corner` and copy it."""
        axes = []
        for start, size, block in zip(corner, self.shape, self.block, strict=True):
            stop = start + block if self.wrap else min(start + block, size)
            axes.append(torch.arange(start, stop, device=self.x.device) % size)
        here = tuple(a.view(-1, *[1] * (len(axes) - 1 - i)) for i, a in enumerate(axes))
        pixels: tuple[slice | Tensor, ...] = (slice(None), *here)
        known = F.pad(self.known[here], self._missing(axes))
        wish = None
        if self.wish is not None:
            wish = Wish(*(F.pad(t[pixels], self._missing(axes)) for t in (self.wish.weight, self.wish.value)))
        choices = self._choose(corner, known, F.pad(self.x[pixels], self._missing(axes)), wish)
        covered = self.known[here] > 0
        cuts = [self._cut(there, cost, self.x[pixels], covered, axes) for there, cost in choices]
        cut = min(cuts, key=lambda cut: cut.cost)
        self.laid.append((corner, cut.there))
        source = self._source(cut.there, axes)
        places = torch.meshgrid(*(torch.arange(s.start, s.stop, device=self.x.device) for s in source), indexing="ij")
        new = self.exemplar.canvas[(slice(None), *source)]
        self.x[pixels] = torch.where(cut.fresh, new, self.x[pixels])
        self.where[pixels] = torch.where(cut.fresh, torch.stack(places), self.where[pixels])
        self.known[here] = 1.0
        self.used[source] += cut.fresh

    def _source(self, there: Sequence[int], axes: Sequence[Tensor]) -> tuple[slice, ...]:
        """The exemplar's pixels for a place with these output coordinates per axis."""
        return tuple(slice(t, t + len(a)) for t, a in zip(there, axes, strict=True))

    def _missing(self, axes: Sequence[Tensor]) -> list[int]:
        """Padding that brings a block cut by the border to full size."""
        padding: list[int] = []
        for block, axis in zip(reversed(self.block), reversed(axes), strict=True):
            padding += [0, block - len(axis)]
        return padding

    def _choose(
        self, corner: tuple[int, ...], known: Tensor, content: Tensor, wish: Wish | None
    ) -> list[tuple[list[int], float]]:
        """Corners of blocks to copy, and their costs: good agreement with what is known and wished for, little used.

        Where there is no seam to compare, or a wish decides, a block of about the least cost is drawn.
        """
        mismatch = self._mismatch(known, content, wish)
        again = self._continuations(corner)
        # in units of what agreement this texture affords: rows that can line up are not torn for the sake of even use
        others = mismatch[self.valid & ~again]
        if len(others) == 0:
            others = mismatch[self.valid]
        unit = (others.min().clamp(min=MISMATCH_FLOOR) * others.quantile(GOOD).clamp(min=MISMATCH_FLOOR)).sqrt()
        used = AVERAGE[known.ndim](self.used[None], self.block, self.grain)[0]
        cost = mismatch / unit + self.usage * (used - mean(self.used)) + CONTINUATION * again
        cost = torch.where(self.valid, cost, math.inf)
        flat = cost.flatten()
        if self.seams > 1 and self.aligned and wish is None and bool(known.any()):
            picks = flat.argsort(stable=True)[: self.seams]
            picks = picks[flat[picks] <= flat.min() + ACCEPTABLE]
        else:
            good = (flat <= flat.min() + TOLERANCE).nonzero()[:, 0]
            picks = good[torch.randint(len(good), (1,), generator=self.generator)]
        places = torch.stack(torch.unravel_index(picks, cost.shape), 1) * torch.tensor(self.grain, device=picks.device)
        return list(zip(places.tolist(), flat[picks].tolist(), strict=True))

    def _mismatch(self, known: Tensor, content: Tensor, wish: Wish | None) -> Tensor:
        """How little the blocks at all places agree with what is known, and with the wish, relative to the variance.

        Each is a mean square of its own, so that neither is diluted by the other; weights below 1 scale the wish's.
        """
        mismatch = torch.zeros(self.valid.shape, device=known.device)
        if self.aligned and bool(known.any()):
            cross = self._correlated(self.weighted, content * known)
            square = self._correlated(self.square[None], known[None])
            constant = total(content.square() * known * self.share)
            mismatch = (square - 2 * cross + constant).clamp(min=0) / (total(known) * self.variance)
        if wish is not None and bool((wish.weight > 0).any()):
            cross = self._correlated(self.weighted, wish.weight * wish.value)
            square = self._correlated(self.weighted * self.exemplar.canvas, wish.weight)
            constant = total(wish.value.square() * wish.weight * self.share)
            count = total(torch.where(wish.weight > 0, wish.weight.clamp(min=1), 0.0) * self.share)
            mismatch = mismatch + (square - 2 * cross + constant).clamp(min=0) / (count.clamp(min=1e-9) * self.variance)
        return mismatch

    def _continuations(self, corner: tuple[int, ...]) -> Tensor:
        """Which blocks would only continue what an overlapping block copied, shaped as `valid`."""
        again = torch.zeros_like(self.valid)
        for other, there in self.laid:
            shift = [c - o for c, o in zip(corner, other, strict=True)]
            if all(abs(s) < b for s, b in zip(shift, self.block, strict=True)):
                place = tuple((t + s) // g for t, s, g in zip(there, shift, self.grain, strict=True))
                if all(0 <= p < n for p, n in zip(place, again.shape, strict=True)):
                    again[place] = True
        return again

    def _correlated(self, image: Tensor, block: Tensor) -> Tensor:
        """Inner products of a block (C, *block) with the image (C, *canvas) at every position on the grain."""
        return CONVOLUTION[block.ndim - 1](image[None], block[None], stride=self.grain)[0, 0]

    def _cut(self, there: list[int], cost: float, old: Tensor, known: Tensor, axes: Sequence[Tensor]) -> "_Cut":
        """Cut a block in: it takes all unknown pixels, and those on its side of the cheapest seam."""
        if not (self.aligned and bool(known.any())):
            return _Cut(there, ~known if self.aligned else torch.ones_like(known), cost)
        new = self.exemplar.canvas[(slice(None), *self._source(there, axes))]
        state = torch.where(known, FREE, TAKE)
        state[self._held(known, axes)] = KEEP
        difference = ((new - old).abs() * self.share).sum(0).mul(COST_LEVELS).round().long().cpu().numpy()
        pairs = []
        for axis in range(known.ndim):
            p, q = along(axis, None, -1, known.ndim), along(axis, 1, None, known.ndim)
            price = difference[p] + difference[q]
            pairs.append((np.zeros_like(price), price, price))
        states = state.cpu().numpy()
        take = best_cut(states, pairs)
        seam = sum(int(part.sum()) for part in seams_after(states, take, pairs))
        length = max(float(total(known.float())) / min(self.overlap), 1.0)
        visible = seam / (2 * COST_LEVELS * self.variance**0.5 * length)
        return _Cut(there, torch.from_numpy(take).to(known.device), cost + visible)

    def _held(self, known: Tensor, axes: Sequence[Tensor]) -> Tensor:
        """Known pixels on the rim of the block whose neighbor outside is known: they must stay to meet it."""
        held = torch.zeros_like(known)
        for axis, line in enumerate(axes):
            for edge, beyond in ((0, int(line[0]) - 1), (-1, int(line[-1]) + 1)):
                if not self.wrap and not 0 <= beyond < self.shape[axis]:
                    continue
                outside = self.known.select(axis, beyond % self.shape[axis])
                rest = [a for k, a in enumerate(axes) if k != axis]
                there = outside[tuple(a.view(-1, *[1] * (len(rest) - 1 - i)) for i, a in enumerate(rest))] > 0
                held.select(axis, edge).logical_or_(known.select(axis, edge) & there)
        return held
