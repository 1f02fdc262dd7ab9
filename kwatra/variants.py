"""The images of an exemplar, each with its mask and origin, and variants of them: mirrored, turned and resized."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import InputError, nearest_known, tensor_of, turned


@dataclass(frozen=True)
class Piece:
    """An image (C, *S) or its variant: where it may be copied from (*S), where each pixel comes from (1 + n, *S), and
    what takes directions to it (2, 2).
    """

    image: Tensor
    mask: Tensor
    origin: Tensor
    turn: Tensor

    @cached_property
    def whole(self) -> Tensor:
        """The image with each hole filled with the nearest pixels: what holes hold is nobody's."""
        if bool(self.mask.all()) or not bool(self.mask.any()):
            return self.image
        return self.image[(slice(None), *nearest_known(self.mask))]


def original(image: Tensor, mask: Tensor | None, index: int) -> Piece:
    """Image number `index` as it was given."""
    axes = [torch.arange(s, device=image.device) for s in image.shape[1:]]
    place = torch.stack(torch.meshgrid(*axes, indexing="ij"))
    number = torch.full_like(place[:1], index)
    whole = torch.ones(image.shape[1:], dtype=torch.bool, device=image.device)
    return Piece(
        image,
        whole if mask is None else mask.to(image.device),
        torch.cat([number, place]),
        torch.eye(2, dtype=torch.float32),
    )


def variants(piece: Piece, mirror: bool, rotate: Sequence[float], scale: Sequence[float]) -> list[Piece]:
    """The piece itself, and mirrored, turned and resized variants of it."""
    for name, values in (("turned by", rotate), ("scaled by", scale)):
        if tensor_of(values).ndim != 1:
            raise InputError(f"variants are {name} {values}; give several numbers, ({values},) for one")
    pieces = [piece]
    if mirror:
        image, mask, origin = (t.flip(-1) for t in (piece.image, piece.mask, piece.origin))
        pieces.append(Piece(image, mask, origin, torch.tensor([[-1.0, 0.0], [0.0, 1.0]], dtype=torch.float32)))
    rotated = [_resampled(p, angle, 1.0) for angle in rotate for p in pieces]
    sized = [_resampled(p, 0.0, factor) for factor in scale for p in pieces]
    return pieces + rotated + sized


def _resampled(piece: Piece, degrees: float, factor: float) -> Piece:
    """The piece turned by `degrees` counterclockwise and enlarged by `factor`, on a canvas that holds all of it."""
    if not (math.isfinite(degrees) and math.isfinite(factor) and 0.1 <= factor <= 10):
        raise InputError(f"a variant is turned by {degrees} and scaled by {factor}; scales are 0.1 to 10")
    angle = math.radians(degrees)
    cos, sin = (round(value, 12) for value in (math.cos(angle), math.sin(angle)))  # quarter turns are exact
    turn = torch.tensor([[cos, sin], [-sin, cos]], dtype=torch.float32) @ piece.turn
    if degrees % 90 == 0 and factor == 1:
        turns = int(degrees // 90)
        image, mask, origin = (torch.rot90(t, turns, (-2, -1)) for t in (piece.image, piece.mask, piece.origin))
        return Piece(image, mask, origin, turn)
    height, width = piece.mask.shape[-2:]
    out_h = max(round(factor * (height * abs(cos) + width * abs(sin))), 1)
    out_w = max(round(factor * (width * abs(cos) + height * abs(sin))), 1)
    size = (out_h, out_w)
    inside = turned(piece.mask.float(), size, degrees, factor, "bilinear") > 1 - 1e-3
    # nearest sampling of coordinates stays exact in float32 up to 2^24
    origin = turned(piece.origin.float(), size, degrees, factor, "nearest").round().long()
    whole = piece.whole  # what is read between pixels is read from four a side
    image = turned(_smoothed(whole, factor), size, degrees, factor, beyond="border", span=(height, width))
    return Piece(image.clamp(whole.amin(), whole.amax()), inside, origin, turn)


def _smoothed(image: Tensor, factor: float) -> Tensor:
    """An image (..., H, W) averaged down to where it is to be made smaller, so that detail does not alias."""
    if factor >= 1:
        return image
    height, width = image.shape[-2:]
    size = [max(math.floor(side * factor), 1) for side in (height, width)]
    small = F.interpolate(image.reshape(1, -1, height, width), size, mode="area")
    return small.view(*image.shape[:-2], *small.shape[-2:])
