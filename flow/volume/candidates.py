"""What candidate windows cost the flow, the rest of the video as it is (thesis equation 31).

Putting a window z in the place of x_p changes the video by d = z - x_p there and by nothing elsewhere, and so the
energy x^T F x by

    d^T (2 (F x)_p + F_pp d),

where F_pp couples the window's own pixels: each with itself, with its neighbors that the same springs read, and with
the pixels of the next frame that its own spring reads. All are looked up where the window lies, so a window costs in
proportion to its pixels.
"""

import torch
from torch import Tensor

from flow.volume.springs import PAIRS, Springs
from kwatra.base import over_channels


class Candidates:
    """Charges windows (N, d, h, w, C) at corners (N, 3) what they raise weight * x^T F x by, over their values' number.

    x (C, T, H, W) is the video as it is. Without one only springs with both ends in the window count: how well it
    flows by itself. What is looked up is kept for the next call with the same corners.
    """

    def __init__(self, springs: Springs, weight: float, x: Tensor | None) -> None:
        self.springs, self.weight = springs, weight
        self.x, self.pull = x, None if x is None else 2 * springs.times(x)
        self._place: _Place | None = None

    def __call__(self, corners: Tensor, windows: Tensor) -> Tensor:
        """The charge (N,)."""
        width = tuple(windows.shape[1:-1])
        if self._place is None or self._place.corners is not corners or self._place.width != width:
            self._place = _Place(self.springs, corners, width, self.x, self.pull)
        values = windows.flatten(1, -2).movedim(-1, 0).contiguous()
        return self.weight * self._place.cost(values) / windows[0].numel()


class _Place:
    """What is known of the springs where N windows of P pixels lie.

    x, pull: the video and 2 F x there, (C, N, P), or None; own: F of each pixel with itself; coupled: with neighbors,
    for each of `PAIRS`; read: of the pixels of the next frame, their numbers in the window and the springs' weights.
    All are (N, P), and 0 for pixels outside of the window.
    """

    def __init__(
        self, springs: Springs, corners: Tensor, width: tuple[int, ...], x: Tensor | None, pull: Tensor | None
    ) -> None:
        self.springs, self.corners, self.width = springs, corners, width
        axes = [torch.arange(size, device=corners.device) for size in width]
        self._inside = torch.stack(torch.meshgrid(*axes, indexing="ij")).flatten(1)
        shape = torch.tensor(springs.shape, device=corners.device)
        frame, row, column = ((corners[:, :, None] + self._inside) % shape[:, None]).unbind(1)
        self._pixels = (frame * shape[1] + row) * shape[2] + column
        self.read = [self._reading(*tables) for tables in zip(*springs.readings, strict=True)]
        self.x = self.pull = None
        if x is not None and pull is not None:
            self.x, self.pull = (values.flatten(1)[:, self._pixels] for values in (x, pull))
            self.own = self._of(springs.diagonal)
            self.coupled = [self._of(c) * self._has(o) for c, o in zip(springs.couplings, PAIRS, strict=True)]

    def cost(self, values: Tensor) -> Tensor:
        """What windows of values (C, N, P) cost, (N,)."""
        if self.x is None or self.pull is None:
            stretched, whole = values.clone(), torch.zeros_like(values[0])
            for number, weight in self.read:
                stretched.addcmul_(weight, values.gather(2, number.expand_as(values)), value=-1)
                whole += weight
            # the weights that a spring reads by sum to 1
            return (over_channels(stretched.square()) * (whole > 1 - 1e-4)).sum(1)
        change = values - self.x
        force = self.pull + self.own * change
        volume = change.unflatten(2, self.width)
        for offset, coupled in zip(PAIRS, self.coupled, strict=True):
            force.addcmul_(coupled, volume.roll((-offset[0], -offset[1]), (3, 4)).flatten(2), value=2)
        for number, weight in self.read:
            force.addcmul_(weight, change.gather(2, number.expand_as(change)), value=-2)
        return over_channels(change.mul_(force)).sum(1)

    def _of(self, table: Tensor) -> Tensor:
        """A table of the video's pixels at those of the windows."""
        return table.flatten()[self._pixels]

    def _has(self, offset: tuple[int, int]) -> Tensor:
        """Whether the window's pixels (P,) have a neighbor in it, so many rows and columns on."""
        has = torch.ones_like(self._inside[0], dtype=torch.bool)
        for axis, step in zip((1, 2), offset, strict=True):
            around = self.springs.wrap and self.width[axis] == self.springs.shape[axis]
            there = self._inside[axis] + step
            has &= (there >= 0) & (there < self.width[axis]) | around
        return has

    def _reading(self, pixel: Tensor, weight: Tensor) -> tuple[Tensor, Tensor]:
        """Numbers in the window, and weights, of one of the pixels (T, H, W) of the next frame that springs read."""
        depth, height, width = self.width
        frames, rows, columns = self.springs.shape
        after = (self._inside[0] + 1) % frames if self.springs.loop else self._inside[0] + 1
        there = self._of(pixel)
        row, column = there // columns - self.corners[:, 1:2], there % columns - self.corners[:, 2:3]
        if self.springs.wrap:
            row, column = row % rows, column % columns
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width) & (after < depth)
        number = torch.where(inside, (after * height + row) * width + column, 0)
        return number, self._of(weight) * inside
