"""What whole pixels are copied from: an exemplar, or it and its variants, in one mosaic (thesis 3.4 A).

All lie side by side in one array with a rim of one repeated pixel each. A pixel of the output then remembers one
number, its place in the mosaic, and its patch's colour at a neighboring pixel is one stride away, rim included. So
every patch has a colour next to each pixel it covers, which is what keeps the matching cost a metric at patch borders.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from kwatra.pieces.seams.stock import Matches, Stock

LEVELS = 8191
"""Colours are compared as integers on this many steps: whole numbers make the cost an exact metric."""


class Mosaic(Stock):
    """A mosaic of sources, a `Stock` whose places are whole numbers.

    `images`: one (C, *shape) float array per source. `bands`: for each source the part of the output, as fractions
    (low, high) of axis `-2`, in which it may be used; None for everywhere. `matrices`: for each source the 2x2 matrix
    that takes the last two axes, from its center, to where the exemplar shows the same; None where none is transformed.
    `homes`: for each source the number of the exemplar that it is a variant of; None where all are of one.
    """

    def __init__(
        self,
        images: Sequence[np.ndarray],
        bands: Sequence[tuple[float, float]] | None = None,
        matrices: Sequence[np.ndarray] | None = None,
        homes: Sequence[int] | None = None,
    ):
        self.images = [np.ascontiguousarray(image, dtype=np.float32) for image in images]
        self.shapes = [image.shape[1:] for image in self.images]
        self.dims = len(self.shapes[0])
        self.bands = list(bands) if bands is not None else None
        self.matrices = [np.eye(2)] * len(self.images) if matrices is None else list(matrices)
        self.homes = np.array([0] * len(self.images) if homes is None else homes)
        self.cell = tuple(max(s[d] for s in self.shapes) + 2 for d in range(self.dims))
        steps = [int(np.prod(self.cell[d + 1 :])) for d in range(self.dims)]
        self.strides = tuple(steps)
        self.cell_size = int(np.prod(self.cell))
        self.low = min(float(image.min()) for image in self.images)
        high = max(float(image.max()) for image in self.images)
        self.step = (high - self.low) / LEVELS or 1.0
        self.place_type = np.int32 if self.cell_size * len(self.images) < 2**30 else np.int64
        self.planes = self._quantized()
        spread = [np.std(plane, dtype=np.float64) for plane in self.images[0]]
        self.variance = float(np.mean(np.square(spread))) / (self.step * LEVELS) ** 2

    def _quantized(self) -> np.ndarray:
        channels = self.images[0].shape[0]
        planes = np.zeros((channels, len(self.images), *self.cell), np.int16)
        for number, (image, shape) in enumerate(zip(self.images, self.shapes, strict=True)):
            inner = tuple(slice(0, n + 2) for n in shape)
            for channel, plane in enumerate(image):
                whole = np.rint((plane - self.low) / self.step).astype(np.int16)
                planes[channel, number][inner] = np.pad(whole, 1, mode="edge")
        return planes.reshape(channels, -1)

    def matching(self, number: int) -> np.ndarray:
        """Source `number` as (C, *shape) float32 in units of the quantized range, centred: for matching."""
        return (self.images[number] - self.low) / (self.step * LEVELS) - np.float32(0.5)

    def matching_at(self, places: np.ndarray) -> np.ndarray:
        """Colours (C, *places.shape) at places of the mosaic, in the units of `matching`."""
        return self.colors(places).astype(np.float32) / np.float32(LEVELS) - np.float32(0.5)

    def nowhere(self, shape: tuple[int, ...]) -> np.ndarray:
        """Places for pixels that have none yet."""
        return np.zeros(shape, self.place_type)

    def places(self, number: int, lines: Sequence[np.ndarray]) -> np.ndarray:
        """Places of the grid spanned by source coordinates `lines` (one array per axis); outside, the rim."""
        total: np.ndarray = np.array(number * self.cell_size, self.place_type)
        for axis, (at, size, stride) in enumerate(zip(lines, self.shapes[number], self.strides, strict=True)):
            line = ((np.minimum(np.maximum(at, -1), size) + 1) * stride).astype(self.place_type)
            total = total + line.reshape([-1] + [1] * (self.dims - 1 - axis))
        return total

    def places_of(self, at: Sequence[np.ndarray]) -> np.ndarray:
        """The places of coordinates in the first source, an array of any shape per axis."""
        there = sum((line + 1) * stride for line, stride in zip(at, self.strides, strict=True))
        return np.asarray(there, self.place_type)

    def counted(self, places: np.ndarray) -> np.ndarray:
        """How often each place of the first source is among some, (*cell)."""
        return np.bincount(places, minlength=self.cell_size).astype(float).reshape(self.cell)

    def coordinates(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(source number, coordinates (dims, ...)) of places in the mosaic, both int32."""
        from kwatra.pieces.loops import locate

        number, at = np.empty(places.shape, np.int32), np.empty((self.dims, *places.shape), np.int32)
        locate(places.ravel(), self.cell_size, np.array(self.strides), number.ravel(), at.reshape(self.dims, -1))
        return number, at

    def mirrored(self, number: int) -> list[int]:
        """The variants of the same exemplar of the other handedness than source `number`."""
        hand, same = np.linalg.det(self.matrices), self.homes == self.homes[number]
        return [int(k) for k in np.flatnonzero(same & (hand * hand[number] < 0))]

    def moved(self, at: np.ndarray, here: int, there: int) -> np.ndarray:
        """Where source `there` shows what source `here` shows at `at` (dims, n), rounded to pixels and not clipped."""
        turn = np.linalg.solve(self.matrices[there], self.matrices[here])
        centers = [(np.array(self.shapes[k][-2:])[:, None] - 1) / 2 for k in (here, there)]
        moved = at.astype(np.int64)
        moved[-2:] = np.rint(turn @ (at[-2:] - centers[0]) + centers[1])
        return moved

    def colors(self, places: np.ndarray) -> np.ndarray:
        """Quantized colors (C, *places.shape) at places."""
        return self.planes.take(places, axis=1)

    def beyond(self, places: np.ndarray, axis: int, step: int) -> np.ndarray:
        """The places one step (1 or -1) along an axis."""
        return np.clip(places + self.place_type(step * self.strides[axis]), 0, self.planes.shape[1] - 1)

    def same(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Whether places are the same."""
        equal: np.ndarray = one == other
        return equal

    def distance(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The sum over channels of the absolute differences of quantized colors; int32."""
        total = np.zeros(np.broadcast_shapes(one.shape[1:], other.shape[1:]), np.int32)
        for a, b in zip(one, other, strict=True):
            total += np.abs(a - b)
        return total

    def matches(self, old: np.ndarray, new: np.ndarray) -> Matches:
        """As `Stock.matches`, in compiled loops."""
        from kwatra.pieces.seams.matches import matched

        return matched(self.planes, self.strides, old, new)

    @cached_property
    def deviation(self) -> float:
        """The standard deviations of all quantized channels together, rim included: the unit of what a seam costs."""
        return sum(float(np.std(plane)) for plane in self.planes)

    @cached_property
    def slopes(self) -> np.ndarray:
        """How much it changes at each place along each axis, (dims, places), rim included: what divides M', int32.

        That is the absolute central difference, summed over channels.
        """
        cells = np.zeros((self.dims, len(self.shapes), *self.cell), np.int32)
        planes = self.planes.reshape(len(self.planes), len(self.shapes), *self.cell)
        for number, shape in enumerate(self.shapes):
            inner = tuple(slice(0, n + 2) for n in shape)
            for axis, cell in enumerate(cells):
                for plane in planes:
                    cell[number][inner] += _slope(plane[number][inner].astype(np.int32), axis)
        return cells.reshape(self.dims, -1)

    def originals(self, places: np.ndarray) -> np.ndarray:
        """Original colours (C, *places.shape) at places of the mosaic, bit for bit."""
        out = np.empty((self.images[0].shape[0], *places.shape), np.float32)
        for row, line in enumerate(places):
            number, at = self.coordinates(line)
            for k in np.unique(number):
                here = number == k
                inside = [np.clip(a[here], 0, n - 1) for a, n in zip(at, self.shapes[k], strict=True)]
                out[:, row][:, here] = self.images[k][(slice(None), *inside)]
        return out


def by_place(values: np.ndarray) -> np.ndarray:
    """Values (*shape) of a mosaic's only source by the number of its places, rim included."""
    return np.pad(values, 1, mode="edge").ravel()


def _slope(values: np.ndarray, axis: int) -> np.ndarray:
    padded = np.pad(values, [(1, 1) if d == axis else (0, 0) for d in range(values.ndim)], mode="edge")
    count = values.shape[axis]
    return np.abs(np.take(padded, range(2, count + 2), axis) - np.take(padded, range(count), axis)) // 2
