"""Where variants of an image show the same: to show one beside another, mirrored, turned or resized, repeats it."""

import numpy as np
import torch
from torch import Tensor

from kwatra.base import nearest_known
from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar
from kwatra.pieces.seams import Array, Mosaic

NO_TWINS = np.empty((0, 0), np.int32)
"""Of a video's pieces, and of those laid at random, none are told."""


def twin_places(exemplar: Exemplar, mosaic: Mosaic) -> Array:
    """Of each place of a mosaic of an exemplar's canvas its twins' places, (twins, cells); as `twins`."""
    found = twins(exemplar)
    tables = np.full((len(found), mosaic.cell_size), -1, mosaic.place_type)
    for table, twin in zip(tables, found, strict=True):
        here = twin.numpy() >= 0
        at = np.unravel_index(twin.numpy()[here], exemplar.shape)
        table[mosaic.places_of(list(here.nonzero()))] = mosaic.places_of(list(at))
    return tables


@kept
def twins(exemplar: Exemplar) -> list[Tensor]:
    """For each other variant of an exemplar's images the pixel of its canvas that shows about what each pixel does.

    Each (*S) long, flat places; -1 where there is none. None of an exemplar without variants; and none of a video's
    frames beside each other, which come from a place more than they have axes.
    """
    if len(exemplar.origin) != 1 + len(exemplar.shape):
        return []
    owner = exemplar.owner.long().cpu()
    families = dict[int, list[int]]()
    for image in range(int(owner.max()) + 1):
        first = (owner == image).nonzero()[:1]
        if len(first):
            families.setdefault(int(exemplar.origin[0][tuple(first[0])]), []).append(image)
    found = [torch.full(owner.shape, -1) for _ in range(max(map(len, families.values()), default=1) - 1)]
    for family in families.values():
        inside = [owner == image for image in family]
        at, shape = _origins(exemplar, inside)
        grids = [_places(at, there, shape) for there in inside]
        for number, there in enumerate(inside):
            for further, twin in enumerate(found[: len(family) - 1], 1):
                twin[there] = grids[(number + further) % len(family)][tuple(at[:, there])]
    return found


def _origins(exemplar: Exemplar, inside: list[Tensor]) -> tuple[Tensor, list[int]]:
    """Where pixels of a family come from, in pixels of this resolution of its first image, (n, *S), and its shape."""
    origin, first = exemplar.origin[1:].cpu(), inside[0].nonzero()
    shape = (first.amax(0) - first.amin(0) + 1).tolist()
    at = torch.zeros_like(origin)
    for axis, size in enumerate(shape):
        own = origin[axis][inside[0]]
        low, high = int(own.min()), int(own.max())
        factor = max(round((high - low) / max(size - 1, 1)), 1)
        at[axis] = (origin[axis] // factor - low // factor).clamp(0, size - 1)
    return at, shape


def _places(at: Tensor, inside: Tensor, shape: list[int]) -> Tensor:
    """The flat place of a variant's pixel that comes from each of the first image (*shape), or from about there."""
    grid = torch.full(shape, -1)
    grid[tuple(at[:, inside])] = inside.flatten().nonzero()[:, 0]
    return grid[tuple(nearest_known(grid >= 0))]
