"""What candidate windows cost the flow, the rest of the video as it is (thesis equation 31).

Putting a window z in the place of x_p changes the video by d = z - x_p there and by nothing elsewhere, and so the
energy x^T F x by

    2 d^T (F x)_p + d^T F_pp d,

where F_pp couples the window's own pixels: each with itself, with its neighbors that the same springs read, and with
the pixels of the next frame that its own spring reads. All are looked up where the window lies, so a window costs in
proportion to its pixels.
"""

import torch
from torch import Tensor

from flow.volume.springs import PAIRS, Springs


class Candidates:
    """Charges windows (N, d, h, w, C) at corners (N, 3) what they raise weight * x^T F x by, over their values' number.

    x (C, T, H, W) is the video as it is. Without one only springs with both ends in the window count: how well it
    flows by itself.
    """

    def __init__(self, springs: Springs, weight: float, x: Tensor | None) -> None:
        self.springs, self.weight = springs, weight
        self.x = None if x is None else _rows(x)
        self.pull = None if x is None else _rows(springs.times(x))

    def __call__(self, corners: Tensor, windows: Tensor) -> Tensor:
        """The charge (N,)."""
        place = _Place(self.springs, corners, tuple(windows.shape[1:-1]))
        values = windows.flatten(1, -2)
        if self.x is None or self.pull is None:
            cost = place.stretch(values)
        else:
            change = values - self.x[place.pixels]
            cost = 2 * (change * self.pull[place.pixels]).sum((1, 2)) + place.form(change)
        return self.weight * cost / values[0].numel()


def _rows(x: Tensor) -> Tensor:
    """(C, *S) as (pixels, C)."""
    return x.flatten(1).T.contiguous()


class _Place:
    """Where N windows of a size lie: numbers (N, P) of their pixels in the video, counted row by row."""

    def __init__(self, springs: Springs, corners: Tensor, width: tuple[int, ...]) -> None:
        self.springs, self.width = springs, width
        self.corners = corners
        axes = [torch.arange(size, device=corners.device) for size in width]
        inside = torch.stack(torch.meshgrid(*axes, indexing="ij"), -1).view(1, -1, 3)
        shape = torch.tensor(springs.shape, device=corners.device)
        at = (corners[:, None] + inside) % shape
        self.pixels = (at[..., 0] * shape[1] + at[..., 1]) * shape[2] + at[..., 2]

    def form(self, change: Tensor) -> Tensor:
        """d^T F_pp d for d (N, P, C), (N,)."""
        own = (self._of(self.springs.diagonal[0])[..., None] * change.square()).sum((1, 2))
        for offset, coupled in zip(PAIRS, self.springs.couplings, strict=True):
            other = self._neighbors(change, offset)
            own = own + 2 * (self._of(coupled) * (change * other).sum(2)).sum(1)
        for read, weight in self._read(change):
            own = own - 2 * (weight * (change * read).sum(2)).sum(1)
        return own

    def stretch(self, values: Tensor) -> Tensor:
        """Squared length (N,) of the springs that lie in the window, which holds values (N, P, C)."""
        stretched, whole = values, torch.zeros_like(self.pixels, dtype=values.dtype)
        for read, weight in self._read(values):
            stretched = stretched - weight[..., None] * read
            whole = whole + weight
        # weights of a spring sum to 1
        return ((whole > 1 - 1e-4) * stretched.square().sum(2)).sum(1)

    def _of(self, table: Tensor) -> Tensor:
        """A table (T, H, W) at the windows' pixels, (N, P)."""
        return table.flatten()[self.pixels]

    def _read(self, values: Tensor) -> list[tuple[Tensor, Tensor]]:
        """What the spring of each pixel reads of the window's values (N, P, C), with its weight (N, P): 0 outside."""
        depth, height, width = self.width
        frames, rows, columns = self.springs.shape
        after = torch.arange(depth, device=values.device) + 1
        after = (after % frames if self.springs.loop else after).repeat_interleave(height * width)
        readings = []
        for pixel, weight in zip(*self.springs.readings, strict=True):
            there = pixel.flatten()[self.pixels]
            row, column = there // columns - self.corners[:, 1:2], there % columns - self.corners[:, 2:3]
            if self.springs.wrap:
                row, column = row % rows, column % columns
            inside = (row >= 0) & (row < height) & (column >= 0) & (column < width) & (after < depth)
            number = torch.where(inside, (after * height + row) * width + column, 0)
            read = values.gather(1, number[..., None].expand(-1, -1, values.shape[2]))
            readings.append((read, self._of(weight) * inside))
        return readings

    def _neighbors(self, values: Tensor, offset: tuple[int, int]) -> Tensor:
        """Each pixel's neighbor, some rows and columns on, 0 outside of the window: (N, P, C)."""
        shifted = values.view(len(values), *self.width, -1)
        for axis, step in zip((2, 3), offset, strict=True):
            size = self.width[axis - 1]
            shifted = shifted.roll(-step, axis)
            if step and not (self.springs.wrap and size == self.springs.shape[axis - 1]):
                shifted = shifted.clone()
                shifted.select(axis, size - 1 if step > 0 else 0).zero_()
        return shifted.reshape(values.shape)
