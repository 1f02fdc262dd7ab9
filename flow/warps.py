"""Moving pictures along a flow: the true inverse of a forward field, and interpolation at the places it gives.

A forward flow f carries what is at q to q + flow(q). The next frame therefore shows at p the color of the q with
q + flow(q) = p (Kwatra 2005, section 6.2); flow is not read at p. `lookup` finds that q for every pixel center,
`warp` reads colors there.
"""

from collections.abc import Callable
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.checks import check_flow, check_mask
from flow.unknown import filled
from kwatra.errors import InputError

_ITERATIONS = 40
_SETTLED = 1e-4
_TOLERANCE = 1e-2
_EDGE = 1e-3


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


def pixel_coordinates(shape: tuple[int, ...] | torch.Size, device: torch.device | str = "cpu") -> Tensor:
    """The x and y of every pixel of a frame of (height, width), as (2, H, W) float32."""
    rows, columns = (torch.arange(size, device=device, dtype=torch.float32) for size in shape)
    y, x = torch.meshgrid(rows, columns, indexing="ij")
    return torch.stack([x, y])


def warp(image: Tensor, coordinates: Tensor, mode: str = "bicubic", wrap: bool = False) -> Tensor:
    """Read an image (C, H, W) at coordinates (2, *S), x first, in pixels: (C, *S).

    mode: "nearest", "bilinear", "bicubic" (Catmull-Rom) or "lanczos" (three lobes), each sharper than the one before;
    the last two may overshoot the image's range. All are exact at whole pixels. Beyond the border the border's pixels
    are read again; with `wrap` the image is periodic. Memory: 4 numbers per pixel read and tap (1, 4, 16 or 36 taps).

    Raises InputError for another mode.
    """
    if mode not in KERNELS:
        raise InputError(f"the interpolation is {mode!r}; give one of {', '.join(KERNELS)}")
    height, width = image.shape[1:]
    columns, across = _taps(coordinates[0].flatten(), width, mode, wrap)
    rows, down = _taps(coordinates[1].flatten(), height, mode, wrap)
    index = (rows[:, :, None] * width + columns[:, None, :]).flatten(1)
    weights = (down[:, :, None] * across[:, None, :]).flatten(1).to(image.dtype)
    table = image.flatten(1).T.contiguous()
    read = F.embedding_bag(index, table, mode="sum", per_sample_weights=weights)
    return read.T.reshape(image.shape[0], *coordinates.shape[1:])


def _nearest(distance: Tensor) -> Tensor:
    return torch.ones_like(distance)


def _linear(distance: Tensor) -> Tensor:
    return 1 - distance.abs()


def _catmull_rom(distance: Tensor) -> Tensor:
    d = distance.abs()
    return torch.where(d <= 1, (1.5 * d - 2.5) * d * d + 1, ((-0.5 * d + 2.5) * d - 4) * d + 2)


def _lanczos(distance: Tensor) -> Tensor:
    # a whole distance has weight 0 or 1, which the sine of a rounded pi is not
    weights = torch.sinc(distance) * torch.sinc(distance / 3)
    return torch.where(distance == distance.round(), (distance == 0).to(weights.dtype), weights)


KERNELS: dict[str, tuple[int, Callable[[Tensor], Tensor]]] = {
    "nearest": (1, _nearest),
    "bilinear": (2, _linear),
    "bicubic": (4, _catmull_rom),
    "lanczos": (6, _lanczos),
}
"""For each mode how many pixels it reads along an axis, and their weight by distance."""


def _taps(place: Tensor, size: int, mode: str, wrap: bool) -> tuple[Tensor, Tensor]:
    """The pixels read at each place along an axis, and their weights, which sum to 1: both (N, taps)."""
    count, kernel = KERNELS[mode]
    first = place.add(0.5).floor() if count == 1 else place.floor() - (count // 2 - 1)
    offsets = torch.arange(count, device=place.device)
    weights = kernel((place - first)[:, None] - offsets)
    if mode == "lanczos":
        weights = weights / weights.sum(1, keepdim=True)
    index = first.long()[:, None] + offsets
    return index % size if wrap else index.clamp_(0, size - 1), weights


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
