"""Where blocks start in the exemplar, and what that comes to for each of them.

A block may hang over the exemplar's border: it then shows less than a whole block. Were it always to lie within the
exemplar, what is seen of it would be its middle, for its rim lies under other blocks: of an exemplar of 256 pixels the
outer 32, which are 44% of it, would hardly ever be shown.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kwatra.base import InputError
from kwatra.base.spans import in_volume, of_volume, span_sums, volume
from kwatra.exemplar import Exemplar
from kwatra.pieces.stock import Array, each


@dataclass(frozen=True, eq=False)
class Corners:
    """First pixels of blocks: those of number i start at i * grain - hang; arrays over them have the shape of `valid`.

    valid (*n): where blocks lie between the exemplar's holes, or hang over its border. shape: the exemplar's. hang: how
    far, at most, a multiple of grain.
    """

    shape: tuple[int, ...]
    block: tuple[int, ...]
    grain: tuple[int, ...]
    hang: tuple[int, ...]
    valid: Array

    @classmethod
    def fitting(cls, exemplar: Exemplar, block: tuple[int, ...], grain: tuple[int, ...]) -> "Corners":
        """Those of blocks that lie within an exemplar, halved until they fit between its holes."""
        while True:
            valid = exemplar.corners(block)[tuple(slice(None, None, g) for g in grain)]
            if bool(valid.any()):
                return cls(exemplar.shape, block, grain, (0,) * len(block), valid.cpu().numpy())
            if all(b <= 2 for b in block):
                raise InputError("the exemplar has no free 2x2 block; its mask leaves too little to copy from")
            block = tuple(max(b // 2, 2) for b in block)

    def hanging(self, hang: tuple[int, ...]) -> "Corners":
        """Those of blocks that may also hang over the border of an exemplar without holes by so many pixels."""
        more = [(h // g, h // g) for h, g in zip(hang, self.grain, strict=True)]
        return replace(self, hang=hang, valid=np.pad(self.valid, more, constant_values=True))

    def at(self, numbers: Array) -> Array:
        """The first pixels (n, axes) of blocks, given by their flat numbers (n,)."""
        corners: Array = np.stack(np.unravel_index(numbers, self.valid.shape), 1) * self.grain - np.array(self.hang)
        return corners

    def continuing(self, places: Array, known: Array) -> Array:
        """How many pixels of boxes (b, *E) come from where each block would have them (b, *n), of those `known`.

        places (b, *E): where they come from, in a mosaic of the exemplar alone.
        """
        from kwatra.pieces.comparing import count_offsets

        boxes, counts = len(known), np.zeros((len(known), *self.valid.shape))
        cell, hang, grain = np.array(self.shape) + 2, np.array(self.hang), np.array(self.grain)
        flat, extent = (places.reshape(boxes, -1), known.reshape(boxes, -1)), np.array(known.shape[1:])
        count_offsets(*flat, extent, cell, hang, grain, np.array(self.valid.shape), counts.reshape(boxes, -1))
        return counts

    def covering(self, needed: Array, known: Array) -> Array:
        """Of which valid blocks (b, *n) the pixels of boxes (b, *E) that are needed, but not known, lie inside."""
        from kwatra.pieces.comparing import cover

        axes, covering = len(self.shape), np.empty((len(needed), *self.valid.shape), bool)
        lines, sizes = of_volume([(line, line) for line in self._corners])[0], in_volume(self.shape, 1)
        seen = volume(needed, axes), volume(known, axes)
        cover(*seen, lines, sizes, volume(np.ascontiguousarray(self.valid), axes), volume(covering, axes))
        return covering

    def around(self, image: Array) -> Array:
        """An image (..., *shape) with as much of nothing around it as blocks may hang over."""
        axes = [(0, 0)] * (image.ndim - len(self.hang))
        return np.pad(image, axes + [(h, h) for h in self.hang]) if any(self.hang) else image

    @cached_property
    def pixels(self) -> Array:
        """How many pixels of the exemplar each block shows."""
        return self.inside(np.ones(self.block))

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


def _within(line: Array, size: int) -> Array:
    """Values no less than 0 and no more than a size; `clip` takes twice as long for so few."""
    return np.minimum(np.maximum(line, 0), size)
