"""Reading an image between its pixels: a warp at given places, as a function and as a linear operator.

Every value that is read is a weighted sum of pixels, so an image (as a vector of its pixels) is multiplied by a sparse
matrix W with a row for each place: (W x)_p = sum_q k(p_1 - q_1) k(p_2 - q_2) x_q with the interpolation's kernel k.
`warp` reads once; `Warp` keeps the rows, and has W's transpose as well.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import torch
from torch import Tensor

from flow.warps.kernels import KERNELS
from kwatra.base import InputError

_CHUNK = 1 << 14


def pixel_coordinates(shape: tuple[int, ...] | torch.Size, device: torch.device | str = "cpu") -> Tensor:
    """The x and y of every pixel of a frame of (height, width), as (2, H, W) float32."""
    rows, columns = (torch.arange(size, device=device, dtype=torch.float32) for size in shape)
    y, x = torch.meshgrid(rows, columns, indexing="ij")
    return torch.stack([x, y])


def warp(image: Tensor, coordinates: Tensor, mode: str = "bicubic", wrap: bool = False) -> Tensor:
    """Read an image (C, H, W) at coordinates (2, *S), x first, in pixels: (C, *S).

    mode: "nearest", "bilinear", "bicubic" (Catmull-Rom) or "lanczos" (three lobes), each sharper than the one before;
    the last two may overshoot the image's range. All are exact at whole pixels. Beyond the border the border's pixels
    are read again; with `wrap` the image is periodic. Memory: three times the result.

    Raises InputError for another mode, or for whole numbers.
    """
    if not (image.is_floating_point() and coordinates.is_floating_point()):
        raise InputError(f"an image holds {image.dtype} and coordinates {coordinates.dtype}; give both as floats")
    flat, places = image.flatten(1).contiguous(), coordinates.flatten(1)
    single = image.dtype == coordinates.dtype == torch.float32  # the loop is compiled for no other
    if single and image.device.type == "cpu" and not (image.requires_grad or coordinates.requires_grad):
        from flow.warps.loops import read

        values = flat.new_empty(len(image), places.shape[1])
        read(places.shape[1], flat, tuple(image.shape[1:]), places.contiguous(), _count(mode), wrap, values)
    else:
        values = torch.cat([part.read(flat) for part in _rows(places, image.shape[1:], mode, wrap)], 1)
    return values.view(len(image), *coordinates.shape[1:])


class Warp:
    """The matrix W of a warp at coordinates (2, *S) of images of `shape` (H, W), x first, in pixels.

    mode and wrap as for `warp`. known (*S): rows where it is False are 0; what their coordinates hold does not matter.
    Memory: 24 bytes per place and pixel that the mode reads along an axis (1, 2, 4 or 6). On the CPU all products are
    the same bits for any number of threads.

    Raises InputError for another mode, or if `known` is of another size.
    """

    def __init__(
        self,
        coordinates: Tensor,
        shape: tuple[int, int],
        mode: str = "bicubic",
        wrap: bool = False,
        known: Tensor | None = None,
    ) -> None:
        self.shape, self.places = tuple(shape), tuple(coordinates.shape[1:])
        if known is not None:
            if known.dtype != torch.bool or tuple(known.shape) != self.places:
                raise InputError(
                    f"what is known has shape {tuple(known.shape)} and type {known.dtype}; give booleans of shape "
                    f"{self.places}, one for each place"
                )
            coordinates = torch.where(known, coordinates, 0.0)
        self._coordinates, self._mode, self._wrap, self._known = coordinates, mode, wrap, known
        _count(mode)

    @cached_property
    def _rows(self) -> "list[_Rows]":
        return list(_rows(self._coordinates, self.shape, self._mode, self._wrap, self._known))

    def __call__(self, image: Tensor) -> Tensor:
        """W x: an image (C, H, W) read at the places, (C, *S)."""
        values = warp(image, self._coordinates, self._mode, self._wrap)
        return values if self._known is None else torch.where(self._known, values, 0.0)

    def transposed(self, values: Tensor) -> Tensor:
        """W^T v: values (C, *S) added to the pixels that they are read from, by the same weights: (C, H, W)."""
        return self._spread(self._rows, values)

    def diagonal(self, weights: Tensor) -> Tensor:
        """The diagonal (C, H, W) of W^T D W, where D has the weights (C, *S) of the places on its diagonal."""
        return self._spread([part.squared() for part in self._rows], weights)

    def entries(self) -> tuple[Tensor, Tensor]:
        """The pixels that each place reads, counted row by row, (K, *S), and their weights: all entries of W.

        A place reads rows of pixels, one after the other; at the border it may read a pixel twice.
        """
        pixels, weights = zip(*(part.entries() for part in self._rows), strict=True)
        return torch.cat(pixels, 1).view(-1, *self.places), torch.cat(weights, 1).view(-1, *self.places)

    def _spread(self, rows: "Sequence[_Rows]", values: Tensor) -> Tensor:
        flat = values.new_zeros(len(values), self.shape[0] * self.shape[1])
        for part, there in zip(rows, values.flatten(1).split(_CHUNK, 1), strict=True):
            part.spread(there, flat)
        return flat.view(len(values), *self.shape)


Taps = list[tuple[Tensor, Tensor]]
"""For each of the pixels that are read along an axis: which one (N,) for each place, and its weight (N,)."""


class _Rows(NamedTuple):
    """Rows of W for some places (N,): W_pq is the product of the weights of q's row and of q's column."""

    down: Taps
    across: Taps
    width: int

    def read(self, flat: Tensor) -> Tensor:
        """Values (C, N) of an image given as (C, H * W)."""
        read = flat.new_zeros(len(flat), len(self.down[0][0]))
        for row, down in self.down:
            line = torch.zeros_like(read)
            for column, across in self.across:
                line.addcmul_(flat.index_select(1, row * self.width + column), across)
            read.addcmul_(line, down)
        return read

    def spread(self, values: Tensor, flat: Tensor) -> None:
        """The transpose of `read`: values (C, N) added to (C, H * W)."""
        for row, down in self.down:
            line = values * down
            for column, across in self.across:
                pixel = row * self.width + column
                for channel, part in zip(flat, line * across, strict=True):
                    channel.index_add_(0, pixel, part)  # in one dimension it adds in the order of the places

    def entries(self) -> tuple[Tensor, Tensor]:
        """Pixels and weights (K, N)."""
        pixels = [row * self.width + column for row, _ in self.down for column, _ in self.across]
        weights = [down * across for _, down in self.down for _, across in self.across]
        return torch.stack(pixels), torch.stack(weights)

    def squared(self) -> "_Rows":
        """The same with the squares of W's entries."""
        down, across = ([(q, weight.square()) for q, weight in _merged(taps)] for taps in (self.down, self.across))
        return _Rows(down, across, self.width)


def _rows(
    coordinates: Tensor, shape: tuple[int, ...], mode: str, wrap: bool, known: Tensor | None = None
) -> Iterator[_Rows]:
    """The rows of W in pieces of bounded size."""
    places = coordinates.flatten(1).split(_CHUNK, 1)
    counted = [None] * len(places) if known is None else known.flatten().split(_CHUNK)
    for place, counts in zip(places, counted, strict=True):
        down = _taps(place[1], shape[0], mode, wrap)
        if counts is not None:
            down = [(row, weight * counts) for row, weight in down]
        yield _Rows(down, _taps(place[0], shape[1], mode, wrap), shape[1])


def _count(mode: str) -> int:
    """How many pixels a mode reads along an axis."""
    if mode not in KERNELS:
        raise InputError(f"the interpolation is {mode!r}; give one of {', '.join(KERNELS)}")
    return KERNELS[mode][0]


def _merged(taps: Taps) -> Taps:
    """The same with every pixel named once: at a border the same pixel is read several times."""
    merged = []
    for number, (pixel, _) in enumerate(taps):
        first = torch.ones_like(pixel, dtype=torch.bool)
        for other, _ in taps[:number]:
            first &= other != pixel
        weights = torch.stack([torch.where(first & (other == pixel), weight, 0.0) for other, weight in taps])
        merged.append((pixel, weights.sum(0)))
    return merged


def _taps(place: Tensor, size: int, mode: str, wrap: bool) -> Taps:
    """What is read along an axis for each place (N,); the weights of a place sum to 1."""
    count, kernel = _count(mode), KERNELS[mode][1]
    base = place.add(0.5).floor() if count == 1 else place.floor()
    first = base.long() - (count - 1) // 2
    pixels = [first + k for k in range(count)]
    indices = [pixel % size if wrap else pixel.clamp_(0, size - 1) for pixel in pixels]
    return list(zip(indices, kernel(place - base), strict=True))
