"""Reading an image between its pixels: a warp at given places, as a function and as a linear operator.

Every value that is read is a weighted sum of pixels, so an image (as a vector of its pixels) is multiplied by a sparse
matrix W with a row for each place: (W x)_p = sum_q k(p_1 - q_1) k(p_2 - q_2) x_q with the interpolation's kernel k.
`warp` reads once; `Warp` keeps the rows, and has W's transpose as well.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from kwatra.base import InputError

_CHUNK = 1 << 14

_WHOLE = 1e-5
"""Places so many px from a pixel are read as lying on it by lanczos: a bound on rounding."""


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

    Raises InputError for another mode.
    """
    flat = image.flatten(1).contiguous()
    rows = _rows(coordinates, image.shape[1:], mode, wrap)
    return torch.cat([part.read(flat) for part in rows], 1).view(len(image), *coordinates.shape[1:])


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
        self._rows = list(_rows(coordinates, self.shape, mode, wrap, known))

    def __call__(self, image: Tensor) -> Tensor:
        """W x: an image (C, H, W) read at the places, (C, *S)."""
        flat = image.flatten(1).contiguous()
        return torch.cat([part.read(flat) for part in self._rows], 1).view(len(image), *self.places)

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
    if mode not in KERNELS:
        raise InputError(f"the interpolation is {mode!r}; give one of {', '.join(KERNELS)}")
    places = coordinates.flatten(1).split(_CHUNK, 1)
    counted = [None] * len(places) if known is None else known.flatten().split(_CHUNK)
    for place, counts in zip(places, counted, strict=True):
        down = _taps(place[1], shape[0], mode, wrap)
        if counts is not None:
            down = [(row, weight * counts) for row, weight in down]
        yield _Rows(down, _taps(place[0], shape[1], mode, wrap), shape[1])


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


def _nearest(f: Tensor) -> list[Tensor]:
    return [torch.ones_like(f)]


def _linear(f: Tensor) -> list[Tensor]:
    return [1 - f, f]


def _catmull_rom(f: Tensor) -> list[Tensor]:
    square = f * f
    return [((1 - 0.5 * f) * f - 0.5) * f, (1.5 * f - 2.5) * square + 1, ((2 - 1.5 * f) * f + 0.5) * f,
            (0.5 * f - 0.5) * square]  # fmt: skip


def _lanczos(f: Tensor) -> list[Tensor]:
    """sinc(d) sinc(d / 3) at d = f - k, but for a factor that their sum takes out; of sines of sums one is needed."""
    sine, cosine = (f * (math.pi / 3)).sin(), (f * (math.pi / 3)).cos()
    weights = []
    for k in range(-2, 4):
        angle = k * math.pi / 3
        third = sine * math.cos(angle) - cosine * math.sin(angle)
        weights.append((-1) ** k * third / (f - k).square())
    # a quotient of roundings next to a whole pixel, where that is all that is seen
    near = [(f - k).abs() < _WHOLE for k in range(-2, 4)]
    at_one = near[2] | near[3]
    exact = [torch.where(at_one, one.to(f), weight) for one, weight in zip(near, weights, strict=True)]
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


def _taps(place: Tensor, size: int, mode: str, wrap: bool) -> Taps:
    """What is read along an axis for each place (N,); the weights of a place sum to 1."""
    count, kernel = KERNELS[mode]
    base = place.add(0.5).floor() if count == 1 else place.floor()
    first = base.long() - (count - 1) // 2
    pixels = [first + k for k in range(count)]
    indices = [pixel % size if wrap else pixel.clamp_(0, size - 1) for pixel in pixels]
    return list(zip(indices, kernel(place - base), strict=True))
