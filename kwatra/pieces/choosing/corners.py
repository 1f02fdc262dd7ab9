"""Where blocks start in the exemplar, and what that comes to for each of them.

A block may hang over the exemplar's border: it then shows less than a whole block. Were it always to lie within the
exemplar, what is seen of it would be its middle, for its rim lies under other blocks: of an exemplar of 256 pixels the
outer 32, which are 44% of it, would hardly ever be shown. It may as well lie on the exemplar's holes, where it shows
nothing: what has to be filled is then filled by blocks that have nothing to hide there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kwatra.base import InputError
from kwatra.base.spans import in_volume, of_volume, span_sums, volume
from kwatra.exemplar import Exemplar
from kwatra.pieces.choosing.fitting import totals
from kwatra.pieces.seams import Array, by_place, each

ROOM = 0.05
"""Blocks fit between holes in at least this part of the places in which they would without holes, else they are made
smaller. Made stones, coins, tiles and letters with a hole of 30 pixels in 128 show .12 of their elements cut; where any
place would do, .19."""

SMALL, SOME = 8, 16
"""Of blocks with at most so many pixels a side so many places do: smaller ones are thousands. Not tuned."""

SEEN = 0.1
"""Each pixel of a block is the exemplar's in at least this part of all blocks that may lie on holes; else they are made
smaller, for parts of an output could hardly be filled. Not tuned."""

LEAST = 16
"""Blocks that may lie on holes have more pixels a side than this along one axis or more. Not tuned."""

SHOWN = 0.5
"""Blocks that may lie on holes show at least this part of themselves. Not tuned."""

WHOLE = 0.5
"""Whole blocks are laid, where those are asked for, unless they would be smaller than so much of what they should be.
One hole of a quarter of an exemplar's side leaves room for larger ones, and so do six small ones."""

ENOUGH = 0.1
"""Of blocks on holes at least this part may be laid in a box: those that leave the least of it empty. Nine photographs
with one hole, or six small ones, score .086 with a half or a fifth of it, .084 with it and .082 with twice as much."""


class Frame(NamedTuple):
    """Where blocks (n,) may start, as compiled loops take it.

    lines: of each of three axes where they start; sizes (3,): the exemplar's; valid (A, B, C): which may be laid. cell,
    hang, grain, shape (axes,): the size of a mosaic's cell, what blocks may hang over, and what they start on
    multiples of, and how many there are along each axis.
    """

    lines: tuple[Array, ...]
    sizes: Array
    valid: Array
    cell: Array
    hang: Array
    grain: Array
    shape: Array


@dataclass(frozen=True, eq=False)
class Corners:
    """First pixels of blocks: those of number i start at i * grain - hang; arrays over them have the shape of `valid`.

    valid (*n): where blocks lie between the exemplar's holes, or hang over its border. shape: the exemplar's. hang: how
    far, at most, a multiple of grain. holes (*shape): what is nobody's of the exemplar, where blocks may lie on that;
    else None.
    """

    shape: tuple[int, ...]
    block: tuple[int, ...]
    grain: tuple[int, ...]
    hang: tuple[int, ...]
    valid: Array
    holes: Array | None = None

    @classmethod
    def fitting(cls, exemplar: Exemplar, block: tuple[int, ...], grain: tuple[int, ...]) -> "Corners":
        """Those of blocks that lie within an exemplar, made smaller until they fit between its holes in many places."""
        on_grain = tuple(slice(None, None, g) for g in grain)
        sizes = [inside.shape for _, inside in exemplar.places()]
        while True:
            valid = exemplar.corners(block)[on_grain].cpu().numpy()
            smaller = _smaller(block, grain)
            smallest = smaller == block
            wanted = ROOM * sum(_places(size, block, grain) for size in sizes)
            wanted = min(wanted, SOME) if all(b <= SMALL for b in block) else wanted
            if valid.any() and (smallest or np.count_nonzero(valid) >= wanted):
                return cls(exemplar.shape, block, grain, (0,) * len(block), valid)
            if smallest:
                size = "x".join(map(str, block))
                raise InputError(f"the exemplar has no free {size} block; its mask leaves too little to copy from")
            block = smaller

    @classmethod
    def on_holes(
        cls, exemplar: Exemplar, block: tuple[int, ...], grain: tuple[int, ...], whole: bool = False
    ) -> "Corners":
        """Those of blocks that lie within the bounds of an exemplar of one image, but maybe on its holes.

        whole: rather between them, for holes cut elements, if they are not much smaller then.
        """
        if whole:
            fitted = cls.fitting(exemplar, block, grain)
            if min(fitted.block) >= WHOLE * min(block):
                return fitted
        holes, size = (exemplar.owner < 0).cpu().numpy(), block
        on_grain = each(slice(None, None, g) for g in grain)
        while holes.any() and any(b > LEAST for b in size):
            starts = np.zeros([max(n - b + 1, 0) for n, b in zip(exemplar.shape, size, strict=True)], np.float32)
            every = np.ones(starts[on_grain].shape, bool)
            corners = cls(exemplar.shape, size, grain, (0,) * len(size), every, holes)._shown_enough()
            starts[on_grain] = corners.valid
            if every.size and totals(starts, (~holes).astype(np.float32)).min() >= SEEN * every.size:
                return corners
            size = _smaller(size, grain)
        return cls.fitting(exemplar, block, grain)

    def hanging(self, hang: tuple[int, ...]) -> "Corners":
        """Those of blocks that may also hang over the exemplar's border by so many pixels."""
        more = [(h // g, h // g) for h, g in zip(hang, self.grain, strict=True)]
        every = replace(self, hang=hang, valid=np.pad(self.valid, more, constant_values=True))
        return every if self.holes is None else every._shown_enough()

    def _shown_enough(self) -> "Corners":
        """Those of blocks that show enough of themselves."""
        return replace(self, valid=self.valid & (self.pixels >= SHOWN * math.prod(self.block)))

    def at(self, numbers: Array) -> Array:
        """The first pixels (..., axes) of blocks, given by their flat numbers (...)."""
        corners: Array = np.stack(np.unravel_index(numbers, self.valid.shape), -1) * self.grain - np.array(self.hang)
        return corners

    def continuing(self, places: Array, known: Array) -> Array:
        """How many pixels of boxes (b, *E) come from where each block would have them (b, *n), of those `known`.

        places (b, *E): where they come from, in a mosaic of the exemplar alone.
        """
        from kwatra.pieces.choosing.comparing import count_offsets

        boxes, extent = len(known), np.array(known.shape[1:])
        counts = np.empty((boxes, self.valid.size))
        count_offsets(places.reshape(boxes, -1), known.reshape(boxes, -1), extent, self.frame, counts)
        return counts.reshape(boxes, *self.valid.shape)

    @cached_property
    def frame(self) -> Frame:
        """The same as compiled loops take it."""
        lines, valid = of_volume([(line, line) for line in self._corners])[0], np.ascontiguousarray(self.valid)
        cell, hang, grain = np.array(self.shape) + 2, np.array(self.hang), np.array(self.grain)
        sizes, shape = in_volume(self.shape, 1), np.array(self.valid.shape)
        return Frame(lines, sizes, volume(valid, len(self.shape)), cell, hang, grain, shape)

    def emptying_least(self, missing: Array) -> Array:
        """The valid blocks (b, *n) that leave least of what is missing (b, *E) of boxes empty."""
        empty = np.rint(self.hidden(missing))
        least, enough = empty[:, self.valid], math.ceil(ENOUGH * np.count_nonzero(self.valid))
        most = np.partition(least, enough - 1, axis=1)[:, enough - 1]
        most = np.minimum(most, np.maximum(missing.sum(tuple(range(1, missing.ndim))) - 1, 0))
        few: Array = empty <= most.reshape(-1, *[1] * self.valid.ndim)
        return few & self.valid

    def hidden(self, values: Array) -> Array:
        """The sums (m, *n) of values (m, *E) of boxes over what lies on holes of each block, or beyond the border."""
        assert self.holes is not None
        lost = np.pad(self.holes, [(h, h) for h in self.hang], constant_values=True)
        return self.on_grain(totals(values.astype(np.float32), lost.astype(np.float32)))

    def around(self, image: Array) -> Array:
        """An image (..., *shape) with as much of nothing around it as blocks may hang over, and nothing in holes."""
        if self.holes is not None:
            image = np.where(self.holes, np.zeros((), image.dtype), image)
        axes = [(0, 0)] * (image.ndim - len(self.hang))
        return np.pad(image, axes + [(h, h) for h in self.hang]) if any(self.hang) else image

    @cached_property
    def owned(self) -> Array:
        """Which places of the exemplar's mosaic blocks show, of none where they show all."""
        return np.empty(0, bool) if self.holes is None else by_place(~self.holes)

    @cached_property
    def pixels(self) -> Array:
        """How many pixels of the exemplar each block shows, 1 if it lies on holes alone."""
        if self.holes is None:
            return self.inside(np.ones(self.block))
        return np.maximum(self.sums(np.pad(~self.holes, 1)), 1)

    def sums(self, values: Array) -> Array:
        """The sum of the exemplar's values under each block, given by place of its mosaic (..., *shape + 2)."""
        return span_sums(values, self.under)

    def inside(self, values: Array) -> Array:
        """The sum of a block's values (..., *E) over what lies inside of the exemplar, of each block (..., *n)."""
        return span_sums(values, self.seen(values.shape[-len(self.shape) :]))

    @cached_property
    def under(self) -> list[tuple[Array, Array]]:
        """Axis by axis the places of the exemplar under each block, from the first to before the last."""
        lines = zip(self._corners, self.block, self.shape, strict=True)
        return [(_within(c, size) + 1, _within(c + extent, size) + 1) for c, extent, size in lines]

    def seen(self, extent: tuple[int, ...]) -> list[tuple[Array, Array]]:
        """Axis by axis the pixels of a box of some extent that lie inside, from the first to before the last."""
        if extent not in self._seen_of:
            lines = zip(self._corners, extent, self.shape, strict=True)
            self._seen_of[extent] = [(_within(-c, most), _within(size - c, most)) for c, most, size in lines]
        return self._seen_of[extent]

    @cached_property
    def _seen_of(self) -> dict[tuple[int, ...], list[tuple[Array, Array]]]:
        return {}

    @cached_property
    def _corners(self) -> list[Array]:
        """Where blocks start, axis by axis."""
        return [np.arange(n) * g - h for n, g, h in zip(self.valid.shape, self.grain, self.hang, strict=True)]

    def on_grain(self, values: Array) -> Array:
        """Values (..., *S) for blocks at every pixel, of those of which blocks may start."""
        steps = (slice(None, g * n, g) for g, n in zip(self.grain, self.valid.shape, strict=True))
        return values[each(steps)]


def _places(size: Sequence[int], block: tuple[int, ...], grain: tuple[int, ...]) -> int:
    """In how many places on the grain a block fits into an image of some size."""
    return math.prod(max(-(-(n - b + 1) // g), 0) for n, b, g in zip(size, block, grain, strict=True))


def _smaller(block: tuple[int, ...], grain: tuple[int, ...]) -> tuple[int, ...]:
    """The next smaller size of blocks that is tried, a multiple of the grain; the same where there is none.

    Blocks start on the grain: smaller ones than that would leave pixels between them empty.
    """
    return tuple(max(b * 7 // 8 // g * g, min(b, max(g, 2))) for b, g in zip(block, grain, strict=True))


def _within(line: Array, size: int) -> Array:
    """Values no less than 0 and no more than a size; `clip` takes twice as long for so few."""
    return np.minimum(np.maximum(line, 0), size)
