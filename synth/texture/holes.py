"""What may be filled, where it lies, and in which parts it is filled."""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra import InputError
from kwatra.base import even_ranges
from synth.texture.form import size_of

AROUND = 256
"""A still is filled from what is at most so many pixels from the hole's bounding box: that looks most like what is
missing, and a photograph of 12 megapixels takes no longer than one of 1. Not tuned."""

LONGEST, BEFORE = 24, 16
"""Of a video at most so many frames are filled at once, from so many more before, and after the last. A fountain of
160x192 takes 36 s so for 72 frames and 74 for 144; 107 and 419 as a whole, and nothing jumps where two parts meet."""

VOXELS, NEAR = 2**20, 32
"""It is filled from about so many pixels of all these frames, of which at least so many on each side are around what is
filled; a hole that is too large for that in several parts. Bounds on time and memory, not tuned."""


def in_time(image: Any, hole: Tensor) -> Tensor:
    """A hole (H, W) of a video for each of its frames, (T, H, W); other holes as they are."""
    if getattr(image, "ndim", 0) < 4 or hole.ndim != 2:
        return hole
    frames = image.shape[1] if isinstance(image, Tensor) else image.shape[0]
    return hole.expand(frames, -1, -1).clone()


def checked_hole(image: Any, hole: Tensor, elsewhere: bool) -> Tensor:
    """The hole; InputError unless it is one of the image, which is one that can be filled.

    elsewhere: whether there is anything to copy from but the image.
    """
    wanted = (3, 4) if isinstance(image, Tensor) else (2, 3, 4)
    if not isinstance(image, (Tensor, np.ndarray)) or image.ndim not in wanted or 0 in image.shape:
        raise InputError(
            "the image to fill must be a tensor (C, H, W), or an array (H, W) or (H, W, C), or a video (C, T, H, W) or "
            "(T, H, W, C), not empty"
        )
    size = size_of(image)
    if hole.dtype != torch.bool or tuple(hole.shape) != size:
        raise InputError(
            f"the hole is {hole.dtype} of shape {tuple(hole.shape)}; give booleans of the image's size {size}"
        )
    if not bool(hole.any()):
        raise InputError("the hole is empty; it is True where the image is to be filled")
    if bool(hole.all()) and not elsewhere:
        raise InputError("the hole covers the whole image and leaves nothing to copy from; give an exemplar")
    return hole


def check_channels(known: Tensor, others: Sequence[Any]) -> None:
    """InputError unless others have as many channels as the known image."""
    for other in others:
        channels = other.shape[0] if isinstance(other, Tensor) else 1 if other.ndim == 2 else other.shape[-1]
        if channels != len(known):
            raise InputError(
                f"an exemplar has {channels} channels but the image {len(known)}; convert it to the same number"
            )


def box_around(hole: Tensor, margins: Sequence[int]) -> tuple[slice, ...]:
    """The hole's bounding box with margins, within the image; its corner lies where all pyramids sample alike."""
    place, margin = hole.nonzero(), torch.tensor(margins)
    low, high = (place.amin(0) - margin).clamp(min=0) // 8 * 8, place.amax(0) + 1 + margin
    return tuple(slice(int(a), min(int(b), size)) for a, b, size in zip(low, high, hole.shape, strict=True))


def parts_to_fill(hole: Tensor) -> Iterator[tuple[tuple[slice, ...], Tensor]]:
    """The parts in which a hole (*S) is filled, one after the other: the box around each, and what is filled there.

    A still's is one. Of a video each has some frames and, where it is large, some rows and columns, and all that is
    missing in its box is filled; what was filled before is known then.
    """
    if hole.ndim == 2:
        near = box_around(hole, [AROUND] * 2)
        yield near, hole[near]
        return
    missing = hole.clone()
    slabs = _cut(hole, 0, LONGEST)
    for frames in slabs:
        slab = torch.zeros_like(hole)
        slab[frames] = hole[frames]
        widest = max(math.isqrt(VOXELS // _seen(slab)) - 2 * NEAR, NEAR)
        for rows, columns in product(_cut(slab, 1, widest), _cut(slab, 2, widest)):
            wanted = torch.zeros_like(hole)
            wanted[frames, rows, columns] = missing[frames, rows, columns]
            if bool(wanted.any()):
                depth, *sides = box_around(wanted, [BEFORE, *[_margin(wanted)] * 2])
                end = depth.stop if frames == slabs[-1] else frames.stop
                near = (slice(depth.start, end), *sides)
                yield near, missing[near].clone()
                missing[near] = False


def _cut(hole: Tensor, axis: int, most: int) -> list[slice]:
    """The part of an axis that a hole (T, H, W) has pixels in, cut into pieces of at most so many; none if it has none.

    All are about as long.
    """
    others = [other for other in range(hole.ndim) if other != axis]
    place = hole.amax(others).nonzero()[:, 0].tolist()
    if not place:
        return []
    first, size = place[0], place[-1] + 1 - place[0]
    return [slice(first + low, first + high) for low, high in even_ranges(size, -(-size // most))]


def _seen(hole: Tensor) -> int:
    """How many frames a part of a hole (T, H, W) is filled from, about."""
    place = hole.flatten(1).any(1).nonzero()[:, 0].tolist()
    return min(place[-1] + 1 - place[0] + 2 * BEFORE, len(hole)) if place else len(hole)


def _margin(hole: Tensor) -> int:
    """How far around the bounding box of a part of a hole (T, H, W) it is filled from, so that VOXELS are seen."""
    place = hole.nonzero()
    height, width = (place.amax(0) - place.amin(0) + 1).tolist()[1:]
    area = VOXELS / _seen(hole)
    return max(math.ceil((math.sqrt((height - width) ** 2 + 4 * area) - height - width) / 4), NEAR)
