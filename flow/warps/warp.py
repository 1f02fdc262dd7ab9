"""Moving pictures along a flow: the true inverse of a forward field, and interpolation at the places it gives.

A forward flow f carries what is at q to q + flow(q). The next frame therefore shows at p the color of the q with
q + flow(q) = p (Kwatra 2005, section 6.2); flow is not read at p. `lookup` finds that q for every pixel center,
`warp` reads colors there.
"""

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from flow.checks import check_flow
from flow.warps.unknown import filled
from kwatra.base import InputError, check_mask

_CHUNK = 1 << 14
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
    are read again; with `wrap` the image is periodic. Memory: three times the result, and 24 floats per place.

    Raises InputError for another mode.
    """
    if mode not in KERNELS:
        raise InputError(f"the interpolation is {mode!r}; give one of {', '.join(KERNELS)}")
    flat = image.flatten(1).contiguous()
    places = coordinates.flatten(1).split(_CHUNK, 1)
    read = [_read(flat, image.shape[1:], place, mode, wrap) for place in places]
    return torch.cat(read, 1).view(len(image), *coordinates.shape[1:])


def _read(flat: Tensor, shape: torch.Size, place: Tensor, mode: str, wrap: bool) -> Tensor:
    """Values (C, N) at places (2, N) of an image of `shape` given as (C, H * W)."""
    columns = _taps(place[0], shape[1], mode, wrap)
    rows = _taps(place[1], shape[0], mode, wrap)
    read = flat.new_zeros(len(flat), place.shape[1])
    for row, down in rows:
        line = torch.zeros_like(read)
        for column, across in columns:
            line.addcmul_(flat.index_select(1, row * shape[1] + column), across)
        read.addcmul_(line, down)
    return read


def _nearest(f: Tensor) -> list[Tensor]:
    return [torch.ones_like(f)]


def _linear(f: Tensor) -> list[Tensor]:
    return [1 - f, f]


def _catmull_rom(f: Tensor) -> list[Tensor]:
    square = f * f
    return [((1 - 0.5 * f) * f - 0.5) * f, (1.5 * f - 2.5) * square + 1, ((2 - 1.5 * f) * f + 0.5) * f,
            (0.5 * f - 0.5) * square]  # fmt: skip


def _lanczos(f: Tensor) -> list[Tensor]:
    distances = [f - k for k in range(-2, 4)]
    weights = [torch.sinc(d) * torch.sinc(d / 3) for d in distances]
    # the sine of a rounded pi is not zero
    exact = [torch.where(f == 0, float(k == 0), w) for k, w in zip(range(-2, 4), weights, strict=True)]
    total = sum(exact[1:], exact[0])
    return [w / total for w in exact]


KERNELS: dict[str, tuple[int, Callable[[Tensor], list[Tensor]]]] = {
    "nearest": (1, _nearest),
    "bilinear": (2, _linear),
    "bicubic": (4, _catmull_rom),
    "lanczos": (6, _lanczos),
}
"""For each mode how many pixels it reads along an axis, and their weights by how far the place lies past the middle
one (or the left one of two), in [0, 1)."""


def _taps(place: Tensor, size: int, mode: str, wrap: bool) -> list[tuple[Tensor, Tensor]]:
    """The pixels (N,) read along an axis for each place (N,), each with its weights (N,), which sum to 1."""
    count, kernel = KERNELS[mode]
    base = place.add(0.5).floor() if count == 1 else place.floor()
    first = base.long() - (count - 1) // 2
    pixels = [first + k for k in range(count)]
    indices = [pixel % size if wrap else pixel.clamp_(0, size - 1) for pixel in pixels]
    return list(zip(indices, kernel(place - base), strict=True))


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
