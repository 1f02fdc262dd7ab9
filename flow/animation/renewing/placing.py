"""Blocks of the exemplar as they are laid into a frame: turned as the copy that is there, and exactly on it."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor

from flow.animation.carrying import JUMP, onward, rigid
from flow.animation.renewing.stock import TURNS
from flow.warps import pixel_coordinates, warp
from kwatra.pieces import Cut, Patch

Spot = tuple[slice, slice]

AGAIN = 1 / 8
"""A block is a copy found again when at least so much of it is there already. Tried: .199 with half, .201 with
twice as much."""


def widened(spot: Spot, reach: int, shape: Sequence[int]) -> tuple[Spot, Spot]:
    """A spot grown by `reach` px within a frame, and where the spot lies in that."""
    grown = [
        slice(max(part.start - reach, 0), min(part.stop + reach, side)) for part, side in zip(spot, shape, strict=True)
    ]
    inner = [slice(part.start - g.start, part.stop - g.start) for part, g in zip(spot, grown, strict=True)]
    return (grown[0], grown[1]), (inner[0], inner[1])


def radians(turn: int) -> float:
    """The angle of a source of `flow.animation.renewing.stock.Coordinates`."""
    return turn * 2 * math.pi / TURNS


def turn_of(angle: Tensor, usable: Tensor) -> int:
    """The source that is turned as most copies of a spot are: by the mean of the angles (h, w) where usable (h, w)."""
    if not bool(usable.any()):
        return 0
    there = angle[usable]
    mean = math.atan2(float(there.sin().mean()), float(there.cos().mean()))
    return round(mean / (2 * math.pi) * TURNS)


def reach(size: int, turn: int) -> int:
    """By how many px more than its own the exemplar must go on around a block, so that it can be laid turned."""
    cos, sin = abs(math.cos(radians(turn))), abs(math.sin(radians(turn)))
    return 0 if turn == 0 else math.ceil(size * (cos + sin - 1) / 2) + 1


def upright(image: Tensor, usable: Tensor, spot: Spot, turn: int) -> tuple[Tensor, Tensor]:
    """What a frame (C, H, W) shows at a spot, seen as it lies in the exemplar, (C, h, w), and where it is known (h, w).

    usable (H, W): where there is texture.
    """
    if turn == 0:
        return image[(slice(None), *spot)], usable[spot]
    size = [part.stop - part.start for part in spot]
    y, x = (part.start + (side - 1) / 2 for part, side in zip(spot, size, strict=True))
    column, row = (
        pixel_coordinates((size[0], size[1]))
        - torch.tensor([size[1] - 1, size[0] - 1], dtype=torch.float32).view(2, 1, 1) / 2
    )
    at = onward(
        torch.tensor([x, y], dtype=torch.float32).view(2, 1, 1),
        torch.tensor(-radians(turn), dtype=torch.float32).view(1, 1),
        row,
        column,
    )
    high = torch.tensor([usable.shape[1] - 1, usable.shape[0] - 1], dtype=torch.float32).view(2, 1, 1)
    there = ((at >= -0.5) & (at <= high + 0.5)).all(0) & (warp(usable[None].float(), at, "nearest")[0] > 0)
    return warp(image, at, "bilinear"), there


def shift_of(corner: Tensor, spot: Spot, turn: int) -> tuple[float, float]:
    """The shift, row first, by which a source has its block with a corner (2,), x first, in the middle of a spot."""
    half = [(part.stop - part.start - 1) / 2 for part in spot]
    below, beside = rigid(torch.tensor(-radians(turn), dtype=torch.float64))
    across, down = (float(corner[1]) + half[0]) * below + (float(corner[0]) + half[1]) * beside
    return spot[0].start + half[0] - float(down), spot[1].start + half[1] - float(across)


def settled(patch: Patch, off: Tensor, usable: Tensor) -> tuple[float, float]:
    """A block's shift, row first, moved by what it is off (2, h, w) the copy that is there, where usable (h, w).

    So a copy found again is straightened where it lies and does not jump; other blocks stay where they are.
    """
    again = usable & (off.square().sum(0) < JUMP**2)
    if float(again.float().mean()) < AGAIN:
        return patch.shift
    across, down = off[:, again].median(1).values.tolist()
    below, beside = rigid(torch.tensor(-radians(patch.number), dtype=torch.float64))
    x, y = down * below + across * beside
    return patch.shift[0] - float(y), patch.shift[1] - float(x)


def bounds(take: Tensor, spot: Spot) -> Spot:
    """The least part of a frame that holds all that is taken at a spot, (h, w), some of which is."""
    rows, columns = (torch.nonzero(take.any(axis))[[0, -1], 0].tolist() for axis in (1, 0))
    (top, bottom), (left, right) = rows, columns
    return (
        slice(spot[0].start + top, spot[0].start + bottom + 1),
        slice(spot[1].start + left, spot[1].start + right + 1),
    )


def taken_by(cut: Cut) -> Tensor:
    """What a cut takes of its patch's box alone, (h, w); nothing wraps."""
    return torch.from_numpy(cut.take[cut.window.box.part(cut.patch.box)])
