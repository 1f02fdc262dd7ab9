"""Overlapping windows on a regular n-D grid, and the two maps between images and windows.

The selection matrices W_p of the thesis (section 5.1, equation 19) stacked for all p in X-dagger are one linear
map: `gather` applies it (image to windows), `scatter` its exact transpose (windows summed back into an image).
Images and videos share this code: the number of axes follows from `shape`.

Windows are stored channels last, (N, *width, C): one row of a window is then one contiguous piece of memory.
A plain grid ends with a window flush against the border, so every pixel is covered; a wrap-around grid continues
past the border at the opposite side.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.windows.flat import row_starts, starts
from kwatra.windows.layout import Covering, per_axis


def channels_last(image: Tensor) -> Tensor:
    """(C, *S) as contiguous (*S, C)."""
    return image.movedim(0, -1).contiguous()


def windows_at(image: Tensor, corners: Tensor, width: tuple[int, ...]) -> Tensor:
    """Windows of a channels-last image whose first pixels are given.

    image (*S, C) contiguous; corners (N, n) integer pixel coordinates in the order of the axes, each window inside
    the image. Returns (N, *width, C).
    """
    channels = image.shape[-1]
    shape = tuple(image.shape[:-1])
    first = starts(corners, shape, 1)
    rows = image.reshape(-1).unfold(0, width[-1] * channels, channels)
    numbers = (first[:, None] + row_starts(shape, width, 1, image.device)).flatten()
    return rows.index_select(0, numbers).view(len(corners), *width, channels)


def step_of(width: int) -> int:
    """The distance between window corners: the largest divisor of the width up to width / 4 (thesis 5.1: w/4)."""
    return max((s for s in range(1, width // 4 + 1) if width % s == 0), default=1)


@dataclass(frozen=True)
class Grid:
    """Windows of `width` pixels every `step` pixels on an image of spatial `shape` (n axes each).

    `step` divides `width` on every axis. With `wrap`, for all axes or one answer for each, the image is periodic and
    windows run over its border.
    `rows` is the range of window rows (positions on the first axis) this grid holds; None means all of them.
    """

    shape: tuple[int, ...]
    width: tuple[int, ...]
    step: tuple[int, ...]
    wrap: bool | tuple[bool, ...] = False
    rows: tuple[int, int] | None = None
    device: torch.device | str = "cpu"

    def __post_init__(self) -> None:
        for size, width, step in zip(self.shape, self.width, self.step, strict=True):
            if width % step:
                raise InputError(f"step is {step}, which does not divide the window width {width}; choose a divisor")
            if width > size:
                raise InputError(f"a window is {width} pixels wide but the image only {size}; choose smaller windows")

    @cached_property
    def wraps(self) -> tuple[bool, ...]:
        """See `Layout.wraps`."""
        return per_axis(self.wrap, len(self.shape))

    @cached_property
    def positions(self) -> tuple[Tensor, ...]:
        """First pixel of the windows along each axis, on the CPU."""
        axes = []
        for size, width, step, wraps in zip(self.shape, self.width, self.step, self.wraps, strict=True):
            last = size - 1 if wraps else size - width
            position = torch.arange(0, last + 1, step)
            if not wraps and position[-1] != last:
                position = torch.cat([position, torch.tensor([last])])
            axes.append(position)
        if self.rows is not None:
            axes[0] = axes[0][slice(*self.rows)]
        return tuple(axes)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of windows along each axis."""
        return tuple(len(p) for p in self.positions)

    def __len__(self) -> int:
        return math.prod(self.counts)

    @cached_property
    def corners(self) -> Tensor:
        """First pixel of every window, (N, n)."""
        return torch.stack(torch.meshgrid(*self.positions, indexing="ij"), -1).reshape(len(self), -1).to(self.device)

    def bands(self, most: int) -> Iterator["Grid"]:
        """The grid cut into bands of whole window rows with about `most` windows each: bounds the memory of a pass."""
        per_row = max(len(self) // self.counts[0], 1)
        height = max(most // per_row, 1)
        for first in range(0, self.counts[0], height):
            yield replace(self, rows=(first, min(first + height, self.counts[0])))

    def gather(self, image: Tensor) -> Tensor:
        """All windows of an image (C, *shape), as (N, *width, C). Memory: that of the windows."""
        first, covered = self._rows_covered
        pixels = channels_last(image.narrow(1, first, min(covered, self.shape[0] - first)))
        if first + covered > self.shape[0]:
            pixels = torch.cat([pixels, channels_last(image.narrow(1, 0, first + covered - self.shape[0]))])
        for axis, width in enumerate(self.width[1:], 1):
            if self.wraps[axis]:
                pixels = torch.cat([pixels, pixels.narrow(axis, 0, width - 1)], axis)
        corners = self.corners.clone()
        corners[:, 0] -= first
        return windows_at(pixels, corners, self.width)

    def scatter(self, windows: Tensor, into: Tensor | None = None) -> Tensor:
        """The transpose of `gather`: windows (N, *width, C) summed into an image (C, *shape).

        into: an image to which they are added, in place, instead of a new one; only rows under windows are touched.
        """
        image = windows.new_zeros(windows.shape[-1], *self.shape) if into is None else into
        values = windows.reshape(*self.counts, *self.width, windows.shape[-1])
        for axis in reversed(range(len(self.shape))):
            # counts and widths of the axes still to be summed lead; those summed already trail as pixels
            values = self._overlap_add(values.movedim(axis, 2 * axis), axis)
        first, rows = self._rows_covered[0], values.movedim(-1, 0)
        before = min(rows.shape[1], self.shape[0] - first)
        image.narrow(1, first, before).add_(rows.narrow(1, 0, before))
        image.narrow(1, 0, rows.shape[1] - before).add_(rows.narrow(1, before, rows.shape[1] - before))
        return image

    @cached_property
    def _rows_covered(self) -> tuple[int, int]:
        """The first row of pixels under windows, and how many rows from there on; with `wrap` they go on at the top."""
        first, last = int(self.positions[0][0]), int(self.positions[0][-1])
        return first, last - first + self.width[0]

    def _overlap_add(self, values: Tensor, axis: int) -> Tensor:
        """Sum the dimensions (count, width) of one axis, at (2 axis, 2 axis + 1), into the pixels under windows."""
        size, width, step = self.shape[axis], self.width[axis], self.step[axis]
        position, dim = self.positions[axis], 2 * axis
        count, length = len(position), int(position[-1]) - int(position[0]) + width
        regular = count if (length - width) % step == 0 else count - 1
        total = values.new_zeros(*values.shape[:dim], length, *values.shape[dim + 2 :])
        for k in range(0, width, step):
            target = total.narrow(dim, k, regular * step).unflatten(dim, (regular, step))
            target += values.narrow(dim, 0, regular).narrow(dim + 1, k, step)
        if regular < count:
            total.narrow(dim, length - width, width).add_(values.select(dim, count - 1))
        if length > size:  # windows ran over the border of a periodic image, onto pixels summed here
            total.narrow(dim, 0, length - size).add_(total.narrow(dim, size, length - size))
        return total.narrow(dim, 0, min(length, size))

    def neighbor_shifts(self, part: slice = slice(None)) -> Iterator[tuple[Tensor, Tensor]]:
        """See `Layout.neighbor_shifts`: the neighbors on the grid. At a plain border a window is its own (shift 0)."""
        numbers, stride = torch.arange(*part.indices(len(self)), device=self.device), len(self)
        lines = zip(self.shape, self.counts, self.positions, self.wraps, strict=True)
        for axis, (size, count, position, wraps) in enumerate(lines):
            stride //= count
            here, position = numbers // stride % count, position.to(self.device)
            for sign in (1, -1):
                there = (here - sign) % count if wraps else (here - sign).clamp(0, count - 1)
                away = position[here] - position[there]
                shift = torch.zeros(len(numbers), len(self.shape), dtype=torch.long, device=self.device)
                shift[:, axis] = (away + size // 2) % size - size // 2 if wraps else away
                yield numbers + (there - here) * stride, shift

    def coverings(self) -> Iterator[Covering]:
        """See `Layout.coverings`; the lower windows first, axis by axis."""
        axes = [self.covering(axis) for axis in range(len(self.shape))]
        for choice in product(*(range(index.shape[1]) for index, _, _ in axes)):
            number = torch.zeros((), dtype=torch.long, device=self.device)
            there = torch.ones((), dtype=torch.bool, device=self.device)
            places = []
            for axis, (k, (index, inside, covered)) in enumerate(zip(choice, axes, strict=True)):
                number = number[..., None] * self.counts[axis] + index[:, k]
                there = there[..., None] & covered[:, k]
                places.append(inside[:, k].view(-1, *[1] * (len(axes) - 1 - axis)))
            yield Covering(number, tuple(places), there)

    def covering(self, axis: int) -> tuple[Tensor, Tensor, Tensor]:
        """For each pixel of an axis the windows covering it, (size, m), the pixel's place in each, and which are there.

        Pixels covered by fewer windows name their first one again. Of a periodic axis those that begin before a pixel
        come first, then those that run over the border to it.
        """
        size, width, position = self.shape[axis], self.width[axis], self.positions[axis]
        pixel = torch.arange(size)
        first, past, over, end = (
            torch.searchsorted(position, pixel + off, right=True) for off in (-width, 0, size - width, size)
        )
        before = past - first
        count = before + (end - over if self.wraps[axis] else 0)
        turn = torch.arange(int(count.max()))
        there = turn < count[:, None]
        turn = torch.where(there, turn, 0)
        index = turn + torch.where(turn < before[:, None], first[:, None], (over - before)[:, None])
        index = index.clamp(max=len(position) - 1)  # of rows alone, pixels beside them have no window at all
        inside = (pixel[:, None] - position[index]) % size
        return index.to(self.device), inside.to(self.device), there.to(self.device)
