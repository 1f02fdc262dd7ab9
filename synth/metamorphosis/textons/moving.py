"""The film of masks: elements that move and change shape, none blended with another.

Elements of A and of B are paired by the least summed way. A pair's place is on the straight line between the
centroids; it is stretched as turns the one's covariance into the other's (optimal transport of Gaussians, `recolor`),
a part of the way; and its shape there is the signed distance to its outline, interpolated between the two outlines so
laid over each other. What has no partner grows from nothing, or shrinks.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import ndimage
from torch import Tensor

from flow.warps import filled
from synth.metamorphosis.assignment import assigned
from synth.metamorphosis.elements import labeled
from synth.metamorphosis.recolor import transport

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_APART = 2.0
"""Px: about the width of what is left between elements that come to overlap. Less than the 1 + sqrt(2) that elements of
A or of B are apart that meet at a corner, so that their own masks stay."""


_REACH = 8
"""Px around elements in which they may grow on their way."""


@dataclass(frozen=True)
class _Shape:
    """An element's signed distance (h, w), above 0 inside, in a box of the frame with a corner (2,).

    center (2,) and covariance (2, 2): those of its pixels. All y first.
    """

    distance: Array
    corner: Array
    center: Array
    covariance: Array

    @classmethod
    def of(cls, labels: NDArray[np.int64], number: int, box: tuple[slice, ...]) -> "_Shape":
        """That of one of some labels (H, W), and the box around it."""
        around = tuple(slice(max(0, side.start - _REACH), side.stop + _REACH) for side in box)
        inside, corner = labels[around] == number, np.array([side.start for side in around], float)
        distance = ndimage.distance_transform_edt(inside) - ndimage.distance_transform_edt(~inside)
        pixels = np.argwhere(inside) + corner
        own = np.eye(2) / 12  # a pixel's
        return cls(np.asarray(distance), corner, pixels.mean(0), np.cov(pixels.T, bias=True) + own)

    @property
    def reach(self) -> Array:
        """How far (2,) the box reaches from the centroid."""
        return np.maximum(self.center - self.corner, self.corner + self.distance.shape - self.center)

    def read(self, matrix: Array, added: Array, shape: tuple[int, ...]) -> Array:
        """The distance where a box of a shape comes from: matrix times its pixels, and what is added then."""
        place = added - self.corner
        return np.asarray(ndimage.affine_transform(self.distance, matrix, place, shape, order=1, mode="nearest"))


@dataclass(frozen=True)
class _Way:
    """An element from its shape in A to that in B, which are one where it has no partner.

    stretch (2, 2): what deviations from the centroid in A are multiplied by in B. sunk: by how much its distances are
    less in A and in B: by more than it is deep where it is not.
    """

    a: _Shape
    b: _Shape
    stretch: Array
    sunk: tuple[float, float]

    @classmethod
    def of(cls, a: _Shape | None, b: _Shape | None) -> "_Way":
        """From A's to B's; None where there is no partner."""
        if a is not None and b is not None:
            return cls(a, b, transport(*map(torch.from_numpy, (a.covariance, b.covariance))).numpy(), (0.0, 0.0))
        only = b if a is None else a
        assert only is not None
        depth = float(only.distance.max()) + 1
        return cls(only, only, np.eye(2), (0.0, depth) if b is None else (depth, 0.0))

    def distance(self, t: float, size: tuple[int, int]) -> tuple[tuple[slice, ...], Array]:
        """A box of a frame of (height, width) around the element at a time, and the signed distance there."""
        sunk = (1 - t) * self.sunk[0] + t * self.sunk[1]
        if t in (0, 1):
            end = self.b if t else self.a
            return _box(end.corner, end.corner + end.distance.shape, size), end.distance - sunk
        reach = np.maximum(self.a.reach, self.b.reach)
        box = _box(self._center(t) - reach, self._center(t) + reach + 1, size)
        corner, shape = np.array([side.start for side in box]), tuple(side.stop - side.start for side in box)
        a, b = (
            end.read(matrix, matrix @ corner + added, shape)
            for end, (matrix, added) in ((self.a, self.back(t, 0)), (self.b, self.back(t, 1)))
        )
        return box, (1 - t) * a + t * b - sunk

    def back(self, now: float, before: float) -> tuple[Array, Array]:
        """What leads from places at one time to those at another: a matrix (2, 2), and what is added then (2,)."""
        matrix = self._stretched(before) @ np.linalg.inv(self._stretched(now))
        return matrix, self._center(before) - matrix @ self._center(now)

    def _center(self, t: float) -> Array:
        return (1 - t) * self.a.center + t * self.b.center

    def _stretched(self, t: float) -> Array:
        return (1 - t) * np.eye(2) + t * self.stretch


@dataclass(frozen=True)
class MovingMasks:
    """The ways of all elements in a frame of (height, width); how many px they cover in A and in B.

    `MovingMasks.of` two masks.
    """

    ways: tuple[_Way, ...]
    size: tuple[int, int]
    covered: tuple[int, int]

    @classmethod
    def of(cls, mask_a: Mask, mask_b: Mask) -> "MovingMasks":
        """From the masks (H, W) of A and B, of one size."""
        a, b = (list(_shapes(mask)) for mask in (mask_a, mask_b))
        rows, columns = assigned(*(np.array([shape.center for shape in shapes]) for shapes in (a, b)))
        ways = [_Way.of(a[i], b[j]) for i, j in zip(rows, columns, strict=True)]
        ways += [_Way.of(a[i], None) for i in sorted(set(range(len(a))) - set(rows))]
        ways += [_Way.of(None, b[j]) for j in sorted(set(range(len(b))) - set(columns))]
        covered = [sum(int((shape.distance > 0).sum()) for shape in shapes) for shapes in (a, b)]
        return cls(tuple(ways), (mask_a.shape[0], mask_a.shape[1]), (covered[0], covered[1]))

    def at(self, t: float) -> Mask:
        """The mask (H, W) at a time from 0, that of A, to 1, that of B."""
        return self._owners(t) >= 0

    def back(self, now: float, before: float) -> Tensor:
        """Where (2, H, W), x first, pixels of a frame were at another time.

        Those of an element move with it, those between elements with the nearest element.
        """
        owners = self._owners(now)
        places = np.mgrid[: self.size[0], : self.size[1]].astype(float)
        moved = np.zeros_like(places)
        for number in np.unique(owners[owners >= 0]):
            matrix, added = self.ways[number].back(now, before)
            inside = owners == number
            moved[:, inside] = matrix @ places[:, inside] + added[:, None] - places[:, inside]
        moved = filled(torch.from_numpy(moved), torch.from_numpy(owners >= 0)).numpy()
        return torch.from_numpy((places + moved)[::-1].copy()).float()

    def _owners(self, t: float) -> NDArray[np.int64]:
        """The number (H, W) of the element that each pixel belongs to, -1 between them.

        That is the one it is deepest in, if by more than _APART deeper than in any other: elements that come to overlap
        stay apart. All are grown alike, or shrunk, until they cover as much as is on the way from A to B.
        """
        deepest, second, owners = np.full(self.size, -np.inf), np.full(self.size, -np.inf), np.full(self.size, -1)
        for number, way in enumerate(self.ways):
            box, distance = way.distance(t, self.size)
            before = deepest[box]
            owners[box] = np.where(distance > before, number, owners[box])
            second[box] = np.maximum(second[box], np.minimum(distance, before))
            deepest[box] = np.maximum(distance, before)
        depth = np.where(deepest > second + _APART, deepest, -np.inf)
        cover = round((1 - t) * self.covered[0] + t * self.covered[1])
        return np.where(depth > np.sort(depth, axis=None)[-cover - 1], owners, -1)


def _shapes(mask: Mask) -> Iterator[_Shape]:
    labels = labeled(mask)
    return (_Shape.of(labels, number, box) for number, box in enumerate(ndimage.find_objects(labels), 1))


def _box(first: Array, last: Array, size: tuple[int, int]) -> tuple[slice, ...]:
    """The pixels of a frame of (height, width) from one place up to another."""
    return tuple(
        slice(max(0, int(begin)), max(0, min(side, int(end))))
        for begin, end, side in zip(first, last, size, strict=True)
    )
