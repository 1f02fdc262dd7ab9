"""The film of masks: elements that move and change shape, none blended with another.

Elements of A and of B are paired by the least summed way. A pair's shape is the signed distance to its outline,
interpolated between the two outlines laid over each other by their centroids; its place is on the straight line
between those. What has no partner grows from nothing, or shrinks.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import ndimage
from torch import Tensor

from flow.warps import free_form
from synth.metamorphosis.assignment import assigned
from synth.metamorphosis.elements import labeled

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FINEST = 6.0


@dataclass(frozen=True)
class _Shape:
    """An element's signed distance (H, W), above 0 inside, and its centroid (2,), x first."""

    distance: Array
    center: Array


@dataclass(frozen=True)
class MovingMasks:
    """Pairs of elements' shapes in A and B; None where there is no partner. `MovingMasks.of` two masks."""

    pairs: tuple[tuple[_Shape | None, _Shape | None], ...]
    size: tuple[int, int]

    @classmethod
    def of(cls, mask_a: Mask, mask_b: Mask) -> "MovingMasks":
        """From the masks (H, W) of A and B, of one size."""
        a, b = _shapes(mask_a), _shapes(mask_b)
        rows, columns = assigned(*(np.array([shape.center for shape in shapes]) for shapes in (a, b)))
        pairs: list[tuple[_Shape | None, _Shape | None]] = [(a[i], b[j]) for i, j in zip(rows, columns, strict=True)]
        pairs += [(a[i], None) for i in sorted(set(range(len(a))) - set(rows))]
        pairs += [(None, b[j]) for j in sorted(set(range(len(b))) - set(columns))]
        return cls(tuple(pairs), (mask_a.shape[0], mask_a.shape[1]))

    def at(self, t: float) -> Mask:
        """The mask (H, W) at a time from 0, that of A, to 1, that of B."""
        inside = np.zeros(self.size, bool)
        for a, b in self.pairs:
            inside |= _between(a, b, t) > 0
        return inside

    def motion(self, begin: float, end: float) -> Tensor:
        """The displacement (2, H, W) of the elements, and all between them, from one time to another."""
        moved = [(a.center, b.center) for a, b in self.pairs if a is not None and b is not None]
        here, there = (torch.tensor(np.array([(1 - t) * p + t * q for p, q in moved])) for t in (begin, end))
        return free_form(here, there - here, self.size, finest=_FINEST).float()


def _shapes(mask: Mask) -> list[_Shape]:
    labels = labeled(mask)
    centers = ndimage.center_of_mass(mask, labels, range(1, labels.max() + 1))
    return [_Shape(_signed(labels == number), np.array(center)[::-1]) for number, center in enumerate(centers, 1)]


def _signed(inside: Mask) -> Array:
    return np.asarray(ndimage.distance_transform_edt(inside) - ndimage.distance_transform_edt(~inside))


def _between(a: _Shape | None, b: _Shape | None, t: float) -> Array:
    """The signed distance (H, W) of an element on its way; without partner it sinks by its depth."""
    if a is None or b is None:
        only, gone = (b, 1 - t) if a is None else (a, t)
        assert only is not None
        return only.distance - gone * (only.distance.max() + 1)
    if t in (0, 1):
        return b.distance if t else a.distance
    way = b.center - a.center
    return (1 - t) * _moved(a.distance, t * way) + t * _moved(b.distance, (t - 1) * way)


def _moved(distance: Array, way: Array) -> Array:
    """A signed distance moved by (x, y)."""
    if not way.any():
        return distance
    return np.asarray(ndimage.shift(distance, way[::-1], order=1, mode="nearest"))
