"""The output while it is made: which patch each pixel comes from, and what the seams between patches cost.

A patch is one source laid down at one offset, cut to a box. Laying it down (thesis section 3.1) solves one minimum cut
over the box: empty pixels must take the patch, filled ones may, fixed ones may not, and pixels around the box stay, so
patches that land wholly on filled ground (surrounded regions, 3.1.2) need nothing special.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kwatra.cut import FREE, KEEP, TAKE, VOID, Costs, along, best_cut, seams_after
from synth.quilting.boxes import Box
from synth.quilting.costs import SeamCost
from synth.quilting.sources import Sources


@dataclass(frozen=True)
class Patch:
    """Source `number` shifted so that its pixel x lies at output pixel x + `shift`, and cut to `box`."""

    number: int
    shift: tuple[int, ...]
    box: Box

    def moved(self, steps: int) -> Patch:
        """The same patch so many steps further along axis 0."""
        start = (self.box.start[0] + steps, *self.box.start[1:])
        return Patch(self.number, (self.shift[0] + steps, *self.shift[1:]), Box(start, self.box.extent))

    def scaled(self, by: tuple[int, ...], shape: tuple[int, ...]) -> Patch:
        """The same patch where every axis is so many times longer, on an output of `shape`."""
        shift, start, extent = (
            tuple(v * f for v, f in zip(values, by, strict=True))
            for values in (self.shift, self.box.start, self.box.extent)
        )
        return Patch(self.number, shift, Box(start, extent).clipped(shape, (False,) * len(shape)))


class Canvas:
    """The state of a synthesis; arrays are indexed by output pixel.

    `label`: the patch of each pixel, an index into `patches`, -1 where empty. `places`: its place in the mosaic.
    `seams`: per axis the remembered cost between a pixel and the next one. `fixed`: pixels that keep their patch.
    """

    def __init__(self, sources: Sources, shape: Sequence[int], periodic: Sequence[bool], cost: SeamCost):
        self.sources, self.cost = sources, cost
        self.shape, self.periodic = tuple(shape), tuple(periodic)
        self.label = np.full(self.shape, -1, np.int32)
        self.places = np.zeros(self.shape, sources.place_type)
        self.seams = np.zeros((len(self.shape), *self.shape), np.int32)
        self.fixed = np.zeros(self.shape, bool)
        self.patches: list[Patch] = []
        self.total = 0

    @property
    def filled(self) -> np.ndarray:
        """The pixels that have a patch."""
        return self.label >= 0

    def longest(self, axis: int) -> int:
        """The longest patch an axis admits: around a closed axis it must leave both its neighbors distinct."""
        return max(self.shape[axis] - 2, 1) if self.periodic[axis] else self.shape[axis]

    def indices(self, box: Box) -> tuple[np.ndarray, ...]:
        """An open mesh of the output pixels of a box; the box may pass the border only on axes that wrap."""
        lines = zip(box.start, box.stop, self.shape, strict=True)
        return np.ix_(*[np.arange(start, stop) % n for start, stop, n in lines])

    def lay(
        self, patch: Patch, *, must: np.ndarray | None = None, must_not: np.ndarray | None = None, cheaper: bool = False
    ) -> bool:
        """Cut a patch into the canvas; True if it changed anything.

        `must`, `must_not`: boolean arrays over the patch's box, pixels that have to take it or may not. With `cheaper`
        the patch is only accepted if the total seam cost falls.
        """
        window = Box(tuple(s - 1 for s in patch.box.start), tuple(e + 2 for e in patch.box.extent))
        window = window.clipped(self.shape, self.periodic)
        at = self.indices(window)
        state = self._state(at, window, patch.box, must, must_not)
        new = self._patch_places(patch, window)
        pairs = self._pairs(at, new)
        take = best_cut(state, pairs)
        seams = seams_after(state, take, pairs)
        change = sum(
            int(s.sum(dtype=np.int64)) - int(a.sum(dtype=np.int64)) for s, (a, _, _) in zip(seams, pairs, strict=True)
        )
        if not take.any() or (cheaper and change >= 0):
            return False
        self._commit(patch, at, take, new, seams)
        self.total += change
        return True

    def _state(
        self, at: tuple[np.ndarray, ...], window: Box, box: Box, must: np.ndarray | None, must_not: np.ndarray | None
    ) -> np.ndarray:
        filled = self.label[at] >= 0
        inner = tuple(slice(b - w, b - w + e) for b, w, e in zip(box.start, window.start, box.extent, strict=True))
        state = np.where(filled, KEEP, VOID)
        core = np.where(filled[inner], FREE, TAKE)
        if must is not None:
            core[must] = TAKE
        if must_not is not None:
            core[must_not] = np.where(filled[inner][must_not], KEEP, VOID)
        core[self.fixed[at][inner]] = KEEP
        state[inner] = core
        return state

    def _patch_places(self, patch: Patch, window: Box) -> np.ndarray:
        steps = zip(window.start, window.stop, patch.box.start, patch.box.stop, patch.shift, strict=True)
        lines = [np.clip(np.arange(low, high), first - 1, last) - shift for low, high, first, last, shift in steps]
        return self.sources.places(patch.number, lines)

    def _pairs(self, at: tuple[np.ndarray, ...], new: np.ndarray) -> list[Costs]:
        """Per axis the costs (a, b, c) of kwatra.cut between neighbors of a window; of empty pixels, anything."""
        old = self.places[at]
        here = self.cost.difference(old, new)
        pairs = []
        for axis, stride in enumerate(self.sources.strides):
            p, q = along(axis, None, -1, old.ndim), along(axis, 1, None, old.ndim)
            old_p, old_q, new_p, new_q = old[p], old[q], new[p], new[q]
            ahead, back = old_p + stride, np.maximum(old_q - stride, 0)
            np.minimum(ahead, self.sources.planes.shape[1] - 1, out=ahead)
            b = self.cost.from_differences(
                axis, here[p] + self.cost.difference(ahead, new_q), (old_p, new_p), (ahead, new_q)
            )
            c = self.cost.from_differences(
                axis, here[q] + self.cost.difference(back, new_p), (back, new_p), (old_q, new_q)
            )
            pairs.append((self.seams[axis][at][p], b, c))
        return pairs

    def _commit(
        self, patch: Patch, at: tuple[np.ndarray, ...], take: np.ndarray, new: np.ndarray, seams: Sequence[np.ndarray]
    ) -> None:
        self.label[at] = np.where(take, len(self.patches), self.label[at])
        self.places[at] = np.where(take, new, self.places[at])
        for axis, cost in enumerate(seams):
            low = tuple(
                line if d != axis else line.take(range(line.shape[axis] - 1), axis) for d, line in enumerate(at)
            )
            self.seams[axis][low] = cost
        self.patches.append(patch)

    def adopt(self, other: Canvas, first: int) -> None:
        """Copy a canvas of the same cross-section in as the steps `first`... of axis 0, and fix its pixels."""
        at = slice(first, first + other.shape[0])
        self.total += other.total - int(self.seams[:, at].sum(dtype=np.int64))
        self.label[at] = other.label + len(self.patches)
        self.places[at] = other.places
        self.seams[:, at] = other.seams
        self.fixed[at] = True
        self.patches += [patch.moved(first) for patch in other.patches]

    def unrolled(self, first: int, margin: int) -> Canvas:
        """The loop that the steps of axis 0 from `first` on are, `margin` steps of its other turns on either side.

        It shows what lies around each pixel of the loop; patches and places are set, seams are not.
        """
        period = self.shape[0] - first
        turn, at = np.divmod(np.arange(-margin, period + margin), period)
        longer = Canvas(self.sources, (len(at), *self.shape[1:]), self.periodic, self.cost)
        longer.places[:] = self.places[first + at]
        turns = np.unique(turn)
        number = (turn - turns[0]) * len(self.patches)
        longer.label[:] = self.label[first + at] + number.reshape(-1, *[1] * (len(self.shape) - 1))
        for step in turns * period + margin - first:
            longer.patches += [patch.moved(int(step)) for patch in self.patches]
        return longer

    def recomputed_seams(self) -> np.ndarray:
        """The seam costs computed anew from places alone, shaped as `seams`; equal to it at every moment."""
        seams = np.zeros_like(self.seams)
        for axis, stride in enumerate(self.sources.strides):
            label, places = np.roll(self.label, -1, axis), np.roll(self.places, -1, axis)
            seam = (self.label != label) & self.filled & (label >= 0)
            if not self.periodic[axis]:
                seam[along(axis, -1, None, seam.ndim)] = False
            s, t = self.places[seam], places[seam]
            seams[axis][seam] = self.cost.pair(axis, (s, t - stride), (s + stride, t))
        return seams
