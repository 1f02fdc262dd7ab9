"""Pixels of an output that are given, as a part of the exemplar: blocks go on from them.

A seam beside them cannot move, so blocks have to agree all along it, and the larger one is the less it does. So they
are laid first, then small blocks along their border; the narrow strip of these that is beside them stays as well, for
a large block laid over it would cost less on the whole, all of that in one straight line. Then blocks are laid as ever.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import nearest_known
from kwatra.exemplar import Exemplar
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array, Mosaic
from kwatra.pieces.sheet import Patch, Sheet

BESIDE = 0.3
"""Height and width of the blocks along the border of what is given, as a part of those of others. Colors step 2.1
times as much across the borders of eight made textures as in them, and 1.3 times across those of sixteen images, with
.3; 1.9 and 1.3 with .25, 2.4 and 1.1 with .4, 2.6 and 1.2 with .6; 3.2 and 1.4 where the strip beside them need not
stay. In holes of four clips they step as much as what was there, 1.2 times as much without such blocks; of a third of
the length in time they take twice as long, and leave .69 of the sharpness in place of .74."""

NARROW = 16
"""They have at most so many pixels. Where pictures of 200 pixels a side are continued by 100 on all sides, in blocks of
half of them, colors step 1.1 times as much across the border as elsewhere, 1.2 times with 20, 1.3 times with 30. Small
blocks are as good where elements stand on a lattice: in six pictures of 128 pixels where they do colors step 1.2 times
as much, 1.5 times without."""


class GivenCopies:
    """Given pixels of an output of some shape, and where in the exemplar they are copied from.

    source (n, *shape): below 0 where none is given; None where none is anywhere. where (*shape): which are; source (n,
    k): that of these k.
    """

    def __init__(self, shape: Sequence[int], source: Tensor | None) -> None:
        if source is None:
            self.where, self.source = np.zeros(shape, bool), np.empty((len(shape), 0), int)
        else:
            self.where = (source >= 0).all(0).cpu().numpy()
            self.source = source.cpu().numpy()[:, self.where]

    @property
    def any(self) -> bool:
        """Whether there are some."""
        return self.source.size > 0

    def owned(self, exemplar: Exemplar) -> Exemplar:
        """An exemplar in which what given pixels are copied from is an image, too, though it be nobody's.

        The same one where it is somebody's.
        """
        at = tuple(torch.from_numpy(line).to(exemplar.owner.device) for line in self.source)
        if bool((exemplar.owner[at] >= 0).all()):
            return exemplar
        return replace(exemplar, owner=exemplar.owner.index_put(at, exemplar.owner.max() + 1))

    def shown(self, values: Array) -> Array:
        """An exemplar's values (..., *S) where they are given, 0 elsewhere, (..., *shape)."""
        there = np.zeros((*values.shape[: values.ndim - len(self.source)], *self.where.shape), values.dtype)
        there[..., self.where] = values[(..., *self.source)]
        return there

    def lay(self, sheet: Sheet[Mosaic]) -> None:
        """Have a sheet on which nothing lies show them, and keep them."""
        shifts, which = np.unique(np.argwhere(self.where).T - self.source, axis=1, return_inverse=True)
        whole = Box((0,) * len(sheet.shape), sheet.shape)
        sheet.label[self.where] = len(sheet.patches) + which.reshape(-1)
        sheet.patches.extend(Patch(0, tuple(shift), whole) for shift in shifts.T.tolist())
        sheet.places[self.where] = sheet.sources.places_of(list(self.source))
        sheet.fixed |= self.where

    def beside(self, block: Sequence[int], overlap: Sequence[int], grain: Sequence[int]) -> list[Box]:
        """Boxes of blocks on a grain, the border of what is given about in their middle; they overlap all along it."""
        border = ndimage.binary_dilation(self.where) & ~self.where
        boxes, reached = list[Box](), np.zeros_like(self.where)
        for pixel in np.argwhere(border).tolist():
            if not reached[tuple(pixel)]:
                sides = zip(pixel, block, grain, self.where.shape, strict=True)
                start = (min(max(at - b // 2, 0), n - b) // g * g for at, b, g, n in sides)
                boxes.append(Box(tuple(start), tuple(block)))
                reach = [(at, (b - o) // 2) for at, b, o in zip(pixel, block, overlap, strict=True)]
                reached[tuple(slice(max(at - half, 0), at + half + 1) for at, half in reach)] = True
        return boxes

    def nearest_first(self, boxes: Iterable[Box]) -> list[Box]:
        """Boxes by how far the middle of each is from what is given, so that all go on from it."""
        if not self.any:
            return list(boxes)
        far = ndimage.distance_transform_edt(~self.where)
        ends = [size - 1 for size in self.where.shape]
        return sorted(boxes, key=lambda box: far[tuple(map(min, box.middle, ends))])

    def near(self, distance: int) -> Array:
        """The pixels at most so far from what is given, counted in steps along the axes."""
        steps: Array = ndimage.distance_transform_cdt(~self.where, "taxicab")
        return steps <= distance

    def covered(self, where: Tensor, canvas: Sequence[int]) -> Tensor:
        """A source map (n, *S) in which the copies beside given pixels go on under them, as far as the canvas goes.

        Windows across the border are then matched first with the copy that they are to continue it with.
        """
        if not self.any or self.where.all():
            return where
        near = nearest_known(torch.from_numpy(~self.where)).to(where.device)
        here = torch.from_numpy(np.indices(self.where.shape)).to(where.device)
        last = torch.tensor([size - 1 for size in canvas], device=where.device).view(-1, *[1] * (where.ndim - 1))
        return torch.minimum((where[(slice(None), *near)] + here - near).clamp(min=0), last)
