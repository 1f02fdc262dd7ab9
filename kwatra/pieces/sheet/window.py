"""What a sheet shows where patches are about to be cut in."""

import math
from collections.abc import Sequence
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
    kept: np.ndarray
    laid: np.ndarray
    fixed: np.ndarray
    places: np.ndarray
    remembered: list[np.ndarray]
    total: int

    def known(self, box: Box, shifts: Array, size: Sequence[int]) -> Array:
        """How many pixels (n,) have a patch of what a box shows of a source of a size (axes,), shifted (n, axes)."""
        from kwatra.pieces.sheet.pixels import count_kept

        first, counts = np.array(self.box.start), np.empty(len(shifts), np.int64)
        count_kept(volume(self.kept, len(first)), shifts - first, self.bounds(box, size), counts)
        return counts

    def bounds(self, box: Box, size: Sequence[int]) -> Array:
        """A source's size, a box's first pixel and that after its last, (3, axes), counted from the window's first."""
        bounds = np.array((size, box.start, box.stop))
        bounds[1:] -= self.box.start
        return bounds

    def recount(self, take: Array, places: Array, shown: Array) -> None:
        """Count how often each place of a mosaic is `shown` (*cell) once the pixels that `take` some show `places`."""
        from kwatra.pieces.sheet.pixels import recount

        recount(take.ravel(), places.ravel(), self.places.ravel(), self.kept.ravel(), shown.reshape(-1))


def seen_in(boxes: Sequence[Box], label: Array, places: Array, fixed: Array, seams: Array) -> list[Window]:
    """The windows of boxes, of any extents, each with arrays of its own; the others are those of a sheet (`Sheet`).

    All are read by one call, and what they have of one kind lies in one array.
    """
    from kwatra.pieces.sheet.pixels import look_around

    axes, extents = label.ndim, [box.extent for box in boxes]
    of_places = [(*places.shape[:-axes], *extent) for extent in extents]
    of_pairs = [tuple(e - (d == axis) for d, e in enumerate(extent)) for extent in extents for axis in range(axes)]
    pixels, totals = sum(map(math.prod, extents)), np.empty(len(boxes), np.int64)
    kept, laid, held = np.empty(pixels, np.int8), np.empty(pixels, np.int8), np.empty(pixels, np.bool_)
    shown = np.empty(sum(map(math.prod, of_places)), places.dtype)
    remembered = np.empty(sum(map(math.prod, of_pairs)), np.int32)
    look_around(
        volume(label, axes), volume(places.reshape(-1, *label.shape), axes), volume(fixed, axes), volume(seams, axes),
        in_volume([box.start for box in boxes], 0), in_volume(extents, 1), kept, laid, held, shown, remembered, totals,
    )  # fmt: skip
    parts = (_parts(kept, extents), _parts(laid, extents), _parts(held, extents), _parts(shown, of_places))
    costs = _parts(remembered, of_pairs)
    along = (costs[first : first + axes] for first in range(0, len(costs), axes))
    return [Window(*of_box) for of_box in zip(boxes, *parts, along, totals.tolist(), strict=True)]


def _parts(values: Array, shapes: Sequence[Sequence[int]]) -> list[Array]:
    """Parts of values (N,) of some shapes, one after the other."""
    ends = [0, *accumulate(map(math.prod, shapes))]
    return [values[a:b].reshape(shape) for (a, b), shape in zip(pairwise(ends), shapes, strict=True)]


def as_volumes(seams: Sequence[Array]) -> tuple[Array, ...]:
    """Costs of seams along each axis, as of AXES axes; of those that there are not none."""
    missing = (np.empty((0, 0, 0), np.int32) for _ in range(AXES - len(seams)))
    return (*missing, *(volume(np.ascontiguousarray(cost), len(seams)) for cost in seams))
