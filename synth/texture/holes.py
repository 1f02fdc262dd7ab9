"""What may be filled, and where it lies."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra import InputError
from synth.texture.form import size_of


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
