"""What a sheet shows where patches are about to be cut in."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from kwatra.base.axes import AXES
from kwatra.base.spans import in_volume, volume
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array


class Window(NamedTuple):
    """What a sheet shows in a box, which is one pixel wider than what patches are cut into: arrays over its pixels.

    kept: what happens to pixels that no patch is laid on (kwatra.cut); laid: to those that one is. fixed: pixels that
    keep their patch. places: what they show; remembered: per axis the cost of the seam between a pixel and the next,
    which come to `total`.
    """

    box: Box
    kept: Array
    laid: Array
    fixed: Array
    places: Array
    remembered: list[Array]
    total: int


class Pixels(NamedTuple):
    """The same of several boxes, as compiled loops take it: flat, what is of one box after what is of the one before.

    starts, extents (b, AXES): of the boxes. kept, laid, fixed (N,); places (k * N,): of each box one number of all
    pixels, then the next; remembered (M,): of each box the seams along one axis, then along the next; totals (b,).
    """

    starts: Array
    extents: Array
    kept: Array
    laid: Array
    fixed: Array
    places: Array
    remembered: Array
    totals: Array


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of boxes, of any extents; numbers: the shape of the numbers that a place is, () where it is one."""

    boxes: Sequence[Box]
    pixels: Pixels
    numbers: tuple[int, ...]

    @classmethod
    def of(cls, boxes: Sequence[Box], label: Array, places: Array, fixed: Array, seams: Array) -> "Windows":
        """All are read by one call; the other arguments are what a sheet has (`Sheet`)."""
        from kwatra.pieces.sheet.pixels import look_around

        axes, (starts, extents) = label.ndim, zip(*((box.start, box.extent) for box in boxes), strict=True)
        pixels = sum(map(math.prod, extents))
        pairs = sum(math.prod(shape) for extent in extents for shape in _pairs(extent))
        numbers = places.shape[:-axes]
        kept, laid, held = np.empty(pixels, np.int8), np.empty(pixels, np.int8), np.empty(pixels, np.bool_)
        shown, remembered = np.empty(math.prod(numbers) * pixels, places.dtype), np.empty(pairs, np.int32)
        begun, large, totals = in_volume(starts, 0), in_volume(extents, 1), np.empty(len(boxes), np.int64)
        seen = Pixels(begun, large, kept, laid, held, shown, remembered, totals)
        every = places.reshape(-1, *label.shape)
        look_around(volume(label, axes), volume(every, axes), volume(fixed, axes), volume(seams, axes), seen)
        return cls(boxes, seen, numbers)

    @classmethod
    def alone(cls, window: Window) -> "Windows":
        """That of one box."""
        box, axes = window.box, len(window.box.start)
        where = in_volume([box.start], 0), in_volume([box.extent], 1)
        flat = window.kept.ravel(), window.laid.ravel(), window.fixed.ravel(), window.places.ravel()
        seams = np.concatenate([cost.ravel() for cost in window.remembered])
        pixels = Pixels(*where, *flat, seams, np.array([window.total]))
        return cls([box], pixels, window.places.shape[: window.places.ndim - axes])

    def __len__(self) -> int:
        return len(self.boxes)

    def __getitem__(self, number: int) -> Window:
        """That of one box."""
        box, pixels = self.boxes[number], self.pixels
        kept, laid, fixed = (self.of_pixels(values, number) for values in (pixels.kept, pixels.laid, pixels.fixed))
        shown, seams = self.of_places(pixels.places, number), self.of_pairs(pixels.remembered, number)
        return Window(box, kept, laid, fixed, shown, seams, int(pixels.totals[number]))

    def counted(self, boxes: Sequence[Box], firsts: Array, shifts: Array, size: Sequence[int]) -> tuple[Array, Array]:
        """Shifts (n, AXES) of a source, and what they show of it, counted from each window's first pixel.

        boxes: in each window; firsts (b + 1,): which of the shifts (n, axes) is the first of each. size (axes,): the
        source's. The second are the bounds (b, 3, AXES) of patches: the size, where each box begins, and has ended.
        """
        begun = self.pixels.starts
        bounds = np.empty((len(boxes), 3, AXES), np.int64)
        bounds[:, 0] = in_volume(size, 1)
        bounds[:, 1] = in_volume([box.start for box in boxes], 0) - begun
        bounds[:, 2] = in_volume([box.stop for box in boxes], 1) - begun
        return in_volume(shifts, 0) - np.repeat(begun, np.diff(firsts), 0), bounds

    def known(self, boxes: Sequence[Box], firsts: Array, shifts: Array, size: Sequence[int]) -> Array:
        """How many pixels (n,) have a patch of what boxes show of a source; arguments: those of `counted`."""
        from kwatra.pieces.sheet.pixels import count_kept

        counts = np.empty(len(shifts), np.int64)
        count_kept(self.pixels, firsts, *self.counted(boxes, firsts, shifts, size), counts)
        return counts

    def of_pixels(self, values: Array, number: int) -> Array:
        """The part (*E) of values (N,) that belongs to one box."""
        first, stop = self._pixels[number : number + 2]
        return values[first:stop].reshape(self.boxes[number].extent)

    def of_places(self, values: Array, number: int) -> Array:
        """The part (..., *E) of places (k * N,) that belongs to one box."""
        first, stop = (math.prod(self.numbers) * count for count in self._pixels[number : number + 2])
        return values[first:stop].reshape(*self.numbers, *self.boxes[number].extent)

    def of_pairs(self, values: Array, number: int) -> list[Array]:
        """The parts, axis by axis, of what pairs of pixels have (M,) that belong to one box."""
        shapes = _pairs(self.boxes[number].extent)
        ends = [*accumulate(map(math.prod, shapes), initial=self._seams[number])]
        return [values[a:b].reshape(shape) for (a, b), shape in zip(pairwise(ends), shapes, strict=True)]

    @cached_property
    def _pixels(self) -> list[int]:
        """How many pixels come before each box, and how many there are."""
        return [*accumulate((math.prod(box.extent) for box in self.boxes), initial=0)]

    @cached_property
    def _seams(self) -> list[int]:
        """The same of pairs of pixels."""
        return [*accumulate((sum(map(math.prod, _pairs(box.extent))) for box in self.boxes), initial=0)]


def _pairs(extent: Sequence[int]) -> list[tuple[int, ...]]:
    """Axis by axis how many pairs of a pixel and the next there are in a box, along each axis."""
    return [tuple(e - (d == axis) for d, e in enumerate(extent)) for axis in range(len(extent))]
