"""Mirrored, rotated and scaled copies of an exemplar (thesis 3.4 A), made before the synthesis starts.

Rotations are by quarter turns, which move pixels without resampling them; so is mirroring. Only the two last axes, the
picture plane, are transformed: time keeps its direction.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.errors import InputError


def rotated_and_mirrored(exemplar: Tensor, rotate: bool, mirror: bool) -> list[Tensor]:
    """The exemplar and its copies; `rotate` adds quarter turns, `mirror` left-right mirror images of each."""
    turned = [torch.rot90(exemplar, turns, (-2, -1)) for turns in range(4 if rotate else 1)]
    flipped = [image.flip(-1) for image in turned] if mirror else []
    return turned + flipped


def scales_between(first: float, last: float, count: int) -> list[float]:
    """`count` scales from `first` to `last`, each the same factor from the next."""
    if not (0 < first < float("inf") and 0 < last < float("inf")):
        raise InputError(f"scale is {first:g}:{last:g} but both ends must be positive, for example 0.5:1")
    if first == last:
        return [first]
    ratio = (last / first) ** (1 / (count - 1))
    return [first * ratio**i for i in range(count)]


def scaled(exemplar: Tensor, scale: float) -> Tensor:
    """The exemplar (C, H, W) or (C, T, H, W) with height and width times `scale`, smoothed where that shrinks it."""
    if scale == 1:
        return exemplar
    size = [max(round(n * scale), 1) for n in exemplar.shape[-2:]]
    flat = exemplar.reshape(-1, 1, *exemplar.shape[-2:])
    small = F.interpolate(flat, size, mode="bilinear", antialias=scale < 1, align_corners=False)
    return small.reshape(*exemplar.shape[:-2], *size)


def bands(count: int) -> list[tuple[float, float]]:
    """Where, top to bottom as fractions, each of `count` scales may be used; neighboring bands overlap by half."""
    width = 2 / (count + 1)
    return [(i * width / 2, i * width / 2 + width) for i in range(count)]
