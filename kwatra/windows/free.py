"""Windows that lie anywhere, not on a grid (Ruiters, Schnabel and Klein 2010, section 4.4)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.base.compiled import Compiled
from kwatra.windows.flat import continued
from kwatra.windows.grid import channels_last, windows_at
from kwatra.windows.layout import Covering, per_axis


@dataclass(frozen=True, eq=False)
class FreeWindows:
    """Windows of `width` with given corners (N, n) int64 on an image of spatial `shape`, a `Layout`.

    Each lies inside the image; along axes that `wrap` the image is periodic and corners are taken modulo its shape. A
    pixel may be covered by no window: it then keeps what it has. Memory: one number per pixel and window covering it.
    """

    shape: tuple[int, ...]
    width: tuple[int, ...]
    places: Tensor
    wrap: bool | tuple[bool, ...] = False

    def __post_init__(self) -> None:
        room = torch.tensor(self.shape) - torch.tensor(self.width)
        if not len(self.places) or bool((room < 0).any()):
            raise InputError(
                f"there are {len(self.places)} windows of {self.width} on an image of {self.shape}; give at least one "
                "that fits"
            )
        corners = self.places.cpu()
        if bool((((corners < 0) | (corners > room)) & ~torch.tensor(self.wraps)).any()):
            raise InputError(f"a window of {self.width} starts outside of an image of {self.shape}; keep all within it")

    @property
    def device(self) -> torch.device:
        """See `Layout.device`."""
        return self.places.device

    @cached_property
    def corners(self) -> Tensor:
        """See `Layout.corners`."""
        return self.places % torch.tensor(self.shape, device=self.device) if any(self.wraps) else self.places

    @cached_property
    def wraps(self) -> tuple[bool, ...]:
        """See `Layout.wraps`."""
        return per_axis(self.wrap, len(self.shape))

    def __len__(self) -> int:
        return len(self.places)

    def bands(self, most: int) -> Iterator["FreeWindows"]:
        """See `Layout.bands`."""
        for part in self.places.split(most):
            yield FreeWindows(self.shape, self.width, part, self.wrap)

    def gather(self, image: Tensor) -> Tensor:
        """See `Layout.gather`."""
        return windows_at(continued(channels_last(image), self), self.corners, self.width)

    def scatter(self, windows: Tensor, into: Tensor | None = None) -> Tensor:
        """See `Layout.scatter`; pixels sum their windows in order, so that bits do not depend on threads."""
        image = windows.new_zeros(windows.shape[-1], *self.shape) if into is None else into
        if self.device.type == "cpu":
            flat = windows.reshape(len(self), -1, len(image)).contiguous()
            _add(math.prod(self.shape), self._pixels, flat, image.view(len(image), -1))
            return image
        for window, inside, there in self.coverings():
            image += (windows[(window, *inside)] * there[..., None]).movedim(-1, 0)
        return image

    def neighbor_shifts(self, part: slice = slice(None)) -> Iterator[tuple[Tensor, Tensor]]:
        """See `Layout.neighbor_shifts`: the 2n nearest others, or, where there are fewer, the window itself."""
        sides, wraps = torch.tensor(self.shape, device=self.device), torch.tensor(self.wraps, device=self.device)
        for there in self._nearest_others[:, part]:
            shift = self.corners[part] - self.corners[there]
            yield there, torch.where(wraps, (shift + sides // 2) % sides - sides // 2, shift)

    @cached_property
    def _nearest_others(self) -> Tensor:
        """The numbers (2n, N) of those windows whose corners lie nearest to each one's; fewer where there are fewer."""
        from scipy.spatial import cKDTree  # a tenth of a second that grids need not spend

        corners = self.corners.cpu().numpy()
        near = min(2 * len(self.shape) + 1, len(corners))
        period = [size if wraps else 0 for size, wraps in zip(self.shape, self.wraps, strict=True)]
        found = torch.from_numpy(cKDTree(corners, boxsize=period).query(corners, near)[1]).view(len(corners), -1)
        return found[:, 1:].T.contiguous().long().to(self.device)

    @cached_property
    def covers(self) -> tuple[Tensor, Tensor, Tensor]:
        """Of the windows that cover each pixel, in order, the number and the pixel's place inside, both (m, pixels).

        int32; pixels and places are counted row by row. Then how many they are, (pixels,).
        """
        count = torch.bincount(self._pixels.flatten(), minlength=math.prod(self.shape))
        window, place = torch.zeros(2, int(count.max()), len(count), dtype=torch.int32)
        _list(len(count), self._pixels.cpu(), torch.zeros(len(count), dtype=torch.int32), window, place)
        return window.to(self.device), place.to(self.device), count

    def coverings(self) -> Iterator[Covering]:
        """See `Layout.coverings`; where fewer windows cover a pixel, window 0 is named, which is not there."""
        windows, places, count = self.covers
        for k, (window, place) in enumerate(zip(windows, places, strict=True)):
            inside, rest = [], place.long().view(self.shape)  # torch.unravel_index loads a compiler that is not used
            for width in reversed(self.width):
                inside.append(rest % width)
                rest = rest // width
            yield Covering(window.long().view(self.shape), tuple(inside[::-1]), (k < count).view(self.shape))

    @cached_property
    def _pixels(self) -> Tensor:
        """The number, counted row by row, of the pixel at each place of each window: (N, places), int32."""
        axes = len(self.shape)
        pixels = torch.zeros(1, dtype=torch.int32, device=self.device)
        for axis, (size, width) in enumerate(zip(self.shape, self.width, strict=True)):
            line = (self.corners[:, axis, None] + torch.arange(width, device=self.device)) % size
            pixels = pixels * size + line.int().view(len(self), *[width if a == axis else 1 for a in range(axes)])
        return pixels.flatten(1)


@Compiled
def _list(pixel: Any, listed: Any, windows: Any, places: Any, low: int, high: int) -> None:
    """Windows and places, in order, of pixels from low to high; pixel (N, places): see `FreeWindows._pixels`."""
    for window in range(len(pixel)):
        for place in range(pixel.shape[1]):
            at = pixel[window, place]
            if low <= at < high:
                windows[listed[at], at], places[listed[at], at] = window, place
                listed[at] += 1


@Compiled
def _add(pixel: Any, windows: Any, image: Any, low: int, high: int) -> None:
    """Windows (N, places, C) added to the pixels of an image (C, pixels) from low to high."""
    for window in range(len(pixel)):
        for place in range(pixel.shape[1]):
            at = pixel[window, place]
            if low <= at < high:
                for channel in range(len(image)):
                    image[channel, at] += windows[window, place, channel]
