"""Mirrored, rotated and scaled variants of an exemplar (thesis 3.4 A), made before the synthesis starts.

Mirroring and quarter turns move pixels without resampling them; of one turned by another angle the largest upright
rectangle is used. Only the two last axes, the picture plane, are transformed: time keeps its direction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import InputError, turned


@dataclass(frozen=True)
class Variant:
    """A transformed exemplar. At (y, x) from its center it shows what the exemplar has at `matrix` (y, x) from its."""

    image: Tensor
    matrix: np.ndarray


def variants(exemplar: Tensor, scale: float, rotate: Sequence[float], mirror: bool) -> list[Variant]:
    """The scaled exemplar, variants turned by the angles of `rotate`, with `mirror` the left-right image of each."""
    base = scaled(exemplar, scale)
    made = [Variant(rotated(base, angle) if angle else base, _turn(angle) / scale) for angle in (0.0, *rotate)]
    flip = np.diag([1.0, -1.0])
    return made + ([Variant(one.image.flip(-1), one.matrix @ flip) for one in made] if mirror else [])


def _turn(degrees: float) -> np.ndarray:
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    return np.array([[cos, sin], [-sin, cos]])


def rotated(exemplar: Tensor, degrees: float) -> Tensor:
    """The largest upright rectangle in the exemplar (C, H, W) or (C, T, H, W) turned counterclockwise."""
    if not math.isfinite(degrees):
        raise InputError(f"rotate is {degrees} but must be an angle in degrees, for example 30")
    if degrees % 90 == 0:
        return torch.rot90(exemplar, int(degrees // 90), (-2, -1))
    height, width = exemplar.shape[-2:]
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    high, wide = _inscribed(height, width, abs(sin), abs(cos))
    found = turned(exemplar, (high, wide), degrees, beyond="reflection")
    return found.clamp(exemplar.amin(), exemplar.amax())


def _inscribed(height: int, width: int, sin: float, cos: float) -> tuple[int, int]:
    """Height and width of the largest upright rectangle in a turned one."""
    short, long = sorted((height, width))
    if short <= 2 * sin * cos * long or abs(sin - cos) < 1e-9:
        # Two corners touch the long sides, half way between them.
        near, far = short / 2 / sin, short / 2 / cos
        high, wide = (far, near) if width >= height else (near, far)
    else:
        scale = cos * cos - sin * sin
        high, wide = (height * cos - width * sin) / scale, (width * cos - height * sin) / scale
    return max(int(high), 1), max(int(wide), 1)


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
