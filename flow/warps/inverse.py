"""The inverse of a forward flow: where the colors of a frame come from in the frame before it.

A forward flow f carries what is at q to q + flow(q). The next frame therefore shows at p the color of the q with
q + flow(q) = p (Kwatra 2005, section 6.2); flow is not read at p. `lookup` finds that q for every pixel center.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from flow.checks import check_flow
from flow.warps.unknown import filled
from flow.warps.warp import pixel_coordinates, warp
from kwatra.base import check_mask

_ITERATIONS = 40
"""Of the fixed point, at the most."""

_SETTLED = 1e-4
"""Px: a place that moves by no more in an iteration is found."""

_TOLERANCE = 1e-2
"""Px by which the flow from a place may miss its pixel; of others the source is not known."""

_EDGE = 1e-3
"""Px that a place may lie beyond the border by rounding."""


class Lookup(NamedTuple):
    """Where the colors of a frame come from in the frame before it.

    coordinates (2, H, W): x and y, in pixels, of the source of each pixel; (0, 0) is the center of the top left
    pixel. known (H, W): False where nothing flows to: no pixel of the frame before, or a masked one. Coordinates are
    finite everywhere, but mean nothing where `known` is False.
    """

    coordinates: Tensor
    known: Tensor


def lookup(forward: Tensor, mask: Tensor | None = None, wrap: bool = False) -> Lookup:
    """Invert a forward flow (2, H, W), x first, in pixels per frame.

    mask (H, W): True where the frame before holds texture; what flows in from elsewhere is not known. wrap: the frame
    is periodic. Between pixels the flow is bilinear. Zero flow gives exactly the pixels' own coordinates, and a shift
    by whole pixels exactly the shifted ones.

    The fixed point of q = p - flow(q) is found by iteration, which converges wherever neighboring pixels move apart,
    or together, by less than a pixel per frame. Where the flow tears its pixels farther apart nothing is known, and
    where it folds, one of the pixels that land on p is taken. Memory: about 40 floats per pixel.

    Raises InputError if the flow is no finite (2, H, W), is longer than the frame, or the mask is of another size.
    """
    check_flow(forward)
    if mask is not None:
        check_mask(mask, forward.shape[1:])
        forward = filled(forward, mask)
    pixels = pixel_coordinates(forward.shape[1:], forward.device).to(forward.dtype)
    coordinates, settled = _fixed_point(forward, pixels, wrap)
    known = settled if wrap else settled & _inside(coordinates)
    if mask is not None:
        known &= warp(mask[None].to(forward.dtype), coordinates, "nearest", wrap)[0] > 0
    return Lookup(coordinates, known)


def _fixed_point(forward: Tensor, pixels: Tensor, wrap: bool) -> tuple[Tensor, Tensor]:
    """Coordinates q (2, H, W) with q + flow(q) = pixels, and where (H, W) that was reached.

    Only pixels that still move are iterated.
    """
    target = pixels.flatten(1)
    place = target - forward.flatten(1)
    active = torch.arange(target.shape[1], device=target.device)
    for _ in range(_ITERATIONS):
        moved = target[:, active] - warp(forward, place[:, active], "bilinear", wrap)
        change = (moved - place[:, active]).abs().amax(0)
        place[:, active] = moved
        active = active[change > _SETTLED]
        if not len(active):
            break
    settled = torch.ones(target.shape[1], dtype=torch.bool, device=target.device)
    residual = place[:, active] + warp(forward, place[:, active], "bilinear", wrap) - target[:, active]
    settled[active] = residual.abs().amax(0) <= _TOLERANCE
    return place.view_as(pixels), settled.view(pixels.shape[1:])


def _inside(coordinates: Tensor) -> Tensor:
    """Where coordinates lie between the centers of the border's pixels, but for rounding."""
    height, width = coordinates.shape[1:]
    x, y = coordinates
    return (x >= -_EDGE) & (x <= width - 1 + _EDGE) & (y >= -_EDGE) & (y <= height - 1 + _EDGE)
