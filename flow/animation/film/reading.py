"""What an exemplar shows at source coordinates."""

from collections.abc import Sequence

import torch
from torch import Tensor

from flow.animation.carrying import AROUND, softened
from flow.warps import warp
from kwatra import Exemplar
from kwatra.base import continued, nearest_owned
from kwatra.source import look_up

_NEAR = 2.0
"""Up to so many px beyond an exemplar's border its last pixels pass for its continuation: a convention."""


def nearest_pixels(source: Tensor, shape: Sequence[int]) -> Tensor:
    """The pixels of a canvas (h, w), row first, nearest to source coordinates (2, *S), x first: (2, *S) long."""
    x, y = source.round().long()
    return torch.stack([y.clamp(0, shape[0] - 1), x.clamp(0, shape[1] - 1)])


def where_inside(values: Tensor, inside: Tensor) -> Tensor:
    """The values (n,) of (H, W) that are inside (H, W), sooner where all are."""
    return values.flatten() if bool(inside.all()) else values[inside]


class Reading:
    """Reads an exemplar between its pixels, by one of the interpolations of `flow.warp`.

    continued (C, h, w): the exemplar's canvas, what is nobody's filled in from the nearest pixel.
    """

    def __init__(self, exemplar: Exemplar, interpolation: str) -> None:
        self._owner, self._interpolation = exemplar.owner, interpolation
        known = exemplar.owner >= 0
        self._whole = bool((exemplar.owner == exemplar.owner[0, 0]).all() & known.all())
        self._pixels = nearest_owned(exemplar.owner)
        self.continued = continued(exemplar.canvas, exemplar.owner)
        colors = exemplar.canvas[:, known]
        self._low, self._high = colors.amin(1)[:, None], colors.amax(1)[:, None]

    def __call__(self, source: Tensor) -> Tensor:
        """The colors at source coordinates (2, *S), x first: (C, *S), within the exemplar's range."""
        return self.within(warp(self.continued, source, self._interpolation))

    def within(self, colors: Tensor) -> Tensor:
        """Colors (C, *S), each channel kept within the exemplar's range."""
        return torch.minimum(torch.maximum(colors.flatten(1), self._low), self._high).view_as(colors)

    def picture(self, source: Tensor, inside: Tensor) -> Tensor:
        """The frame (C, H, W) that source coordinates (2, H, W) show, its seams softened where inside (H, W)."""
        return softened(self(source), source, inside, self)

    def pixels(self, source: Tensor) -> Tensor:
        """The pixels of the exemplar, row first, nearest to source coordinates (2, H, W), x first: (2, H, W) long."""
        near = nearest_pixels(source, self._owner.shape)
        return near if self._whole else look_up(self._pixels, near)

    def usable(self, source: Tensor) -> Tensor:
        """Where (*S) source coordinates (2, *S) lie in an exemplar, not beyond its border or in a hole."""
        (x, y), (height, width) = source, self._owner.shape
        within = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
        if self._whole:
            return within
        size = torch.tensor([width, height], device=source.device).view(2, *(1 for _ in source.shape[1:]))
        corners = [end.long().clamp(min=0).minimum(size - 1) for end in (source.floor(), source.ceil())]
        owners = [self._owner[y[1], x[0]] for y in corners for x in corners]
        same = torch.stack([owner == owners[0] for owner in owners[1:]]).all(0)
        return within & same & (owners[0] >= 0)

    def joined(self, source: Tensor) -> Tensor:
        """Where (h, w) source coordinates (2, h, w) lie in the same one of an exemplar's pictures as the middle one."""
        if self._whole:
            return self.usable(source)
        row, column = nearest_pixels(source, self._owner.shape)
        owner = self._owner[row, column]
        return self.usable(source) & (owner == owner[owner.shape[0] // 2, owner.shape[1] // 2])

    def lost(self, source: Tensor) -> Tensor:
        """Where (H, W) source coordinates (2, H, W) lie so far from what is usable that no texture is there."""
        lost = ~self.usable(source)
        beyond = source[:, lost]
        near = [
            self.usable(beyond + _NEAR * torch.tensor(step, dtype=torch.float32, device=source.device)[:, None])
            for step in AROUND
        ]
        lost[lost.clone()] = ~torch.stack(near).any(0)
        return lost
