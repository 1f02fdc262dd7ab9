"""Windows that lie anywhere, not on a grid (Ruiters, Schnabel and Klein 2010, section 4.4)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.windows.flat import continued
from kwatra.windows.grid import channels_last, windows_at
from kwatra.windows.layout import Covering, per_axis


@dataclass(frozen=True, eq=False)
class FreeWindows:
    """Windows of `width` with given corners (N, n) int64 on an image of spatial `shape`, a `Layout`.

    Each lies inside the image; along axes that `wrap` the image is periodic and
    corners are taken modulo its shape. A pixel may
    be covered by no window: it then keeps what it has. Memory: one number per pixel and window that covers it.
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
        for window, inside, there in self.coverings():
            image += (windows[(window, *inside)] * there[..., None]).movedim(-1, 0)
        return image

    def neighbor_shifts(self) -> Iterator[tuple[Tensor, Tensor]]:
        """See `Layout.neighbor_shifts`: the 2n nearest others, or, where there are fewer, the window itself."""
        from scipy.spatial import cKDTree  # a tenth of a second that grids need not spend

        corners = self.corners.cpu().numpy()
        near = min(2 * len(self.shape) + 1, len(corners))
        period = [size if wraps else 0 for size, wraps in zip(self.shape, self.wraps, strict=True)]
        found = torch.from_numpy(cKDTree(corners, boxsize=period).query(corners, near)[1]).view(len(corners), -1)
        sides, wraps = torch.tensor(self.shape, device=self.device), torch.tensor(self.wraps, device=self.device)
        for column in found[:, 1:].T:
            there = column.to(self.device).long()
            shift = self.corners - self.corners[there]
            yield there, torch.where(wraps, (shift + sides // 2) % sides - sides // 2, shift)

    @cached_property
    def _covers(self) -> tuple[Tensor, Tensor]:
        """The windows that cover each pixel (m, pixels), in order, and how many they are (pixels,)."""
        axes = []
        for axis, (size, width) in enumerate(zip(self.shape, self.width, strict=True)):
            line = (self.corners[:, axis, None] + torch.arange(width, device=self.device)) % size
            axes.append(line.view(len(self), *[width if a == axis else 1 for a in range(len(self.shape))]))
        pixel = torch.zeros(1, dtype=torch.long, device=self.device)
        for line, size in zip(axes, self.shape, strict=True):
            pixel = pixel * size + line
        order = pixel.flatten().argsort(stable=True)
        pixel, window = pixel.flatten()[order], order // pixel[0].numel()
        count = torch.bincount(pixel, minlength=int(torch.tensor(self.shape).prod()))
        rank = torch.arange(len(pixel), device=self.device) - (count.cumsum(0) - count)[pixel]
        covers = torch.zeros(int(count.max()), len(count), dtype=torch.long, device=self.device)
        covers[rank, pixel] = window
        return covers, count

    def coverings(self) -> Iterator[Covering]:
        """See `Layout.coverings`; a pixel that no window covers names window 0, which is not there."""
        covers, count = self._covers
        axes = [torch.arange(s, device=self.device) for s in self.shape]
        pixel = torch.meshgrid(*axes, indexing="ij")
        for k, number in enumerate(covers):
            there = (k < count).view(self.shape)
            window = torch.where(there, number.view(self.shape), covers[0].view(self.shape))
            inside = []
            for axis, (line, size, width) in enumerate(zip(pixel, self.shape, self.width, strict=True)):
                place = line - self.corners[:, axis][window]
                inside.append((place % size).clamp(max=width - 1))
            yield Covering(window, tuple(inside), there)
