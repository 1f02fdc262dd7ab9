"""Copies: the regions of a frame in which neighboring pixels show neighboring places of the exemplar.

Within a copy the offset between a pixel and its source changes little from pixel to pixel; where two copies meet, it
jumps. A carried seam frays, for each pixel keeps the copy that is nearest: `tidied` takes the crumbs away, and
`softened` shows the seam between two pixels as a camera would, with a little of both.
"""

from collections.abc import Callable

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import pixel_coordinates

JUMP = 1.5
"""Offsets of neighboring pixels that differ by this many px or more belong to two copies. Tried: .203 with 1, .199 with
2.5."""

_BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))
AROUND = (*_BESIDE, (1, 1), (1, -1), (-1, 1), (-1, -1))
"""The steps, in rows and columns, to the eight pixels around one."""

_FEW = 2
"""A pixel is a crumb when no more than this many of the eight around it belong to its copy. Tried: .201 with 1,
.200 with 3."""

_ROUNDS = 8
"""So often crumbs are looked for, at most; those of larger ones that are left after that wait for the next frame."""

_BLEED = 0.125
"""What a pixel at a seam shows of each of the four beside it that belong to another copy. Tried: .202 with 0, .201 with
.2."""


def offsets(source: Tensor) -> Tensor:
    """How far (2, H, W), in px, each pixel's source (2, H, W) is from the pixel itself."""
    return source - pixel_coordinates(source.shape[1:], source.device)


def changes(offset: Tensor) -> tuple[tuple[Tensor, Tensor], tuple[Tensor, Tensor]]:
    """What offsets (2, H, W) change by from each pixel to the one below and to the one on its right.

    Each, (2, H - 1, W) and (2, H, W - 1), comes with where the two pixels belong to one copy.
    """
    down, right = offset.diff(dim=1), offset.diff(dim=2)
    return (down, _near(down, 0)), (right, _near(right, 0))


def distortion(source: Tensor) -> Tensor:
    """How much more or less of the exemplar's area than its own each pixel shows, (H, W).

    It is the square of the determinant of the source's derivative less 1, at most 1; 0 between copies. Turning and
    shearing keep areas.
    """
    (down, one), (right, other) = changes(offsets(source))
    down, one = F.pad(down, (0, 0, 0, 1)), F.pad(one, (0, 0, 0, 1))
    right, other = F.pad(right, (0, 1)), F.pad(other, (0, 1))
    area = (1 + right[0]) * (1 + down[1]) - right[1] * down[0]
    return torch.where(one & other, (area - 1).square().clamp(max=1), 0.0)


def turns(source: Tensor) -> Tensor:
    """What takes directions in the exemplar, x first, y down, to those of the pixels of its copies: (2, 2, H, W).

    It is the rotation next to the inverse of the derivative of source coordinates (2, H, W).
    """
    (down, one), (right, other) = changes(offsets(source))
    down, right = _meant(down * one, one, 1), _meant(right * other, other, 2)
    angle = torch.atan2(right[1] - down[0], 2 + right[0] + down[1])
    cos, sin = angle.cos(), angle.sin()
    return torch.stack([torch.stack([cos, sin]), torch.stack([-sin, cos])])


def _meant(change: Tensor, counts: Tensor, axis: int) -> Tensor:
    """At each pixel (2, H, W) the mean change to the next one and from the one before, of those that count."""
    values = torch.cat([change, counts[None].to(change)]).transpose(axis, 2)
    both = (F.pad(values, (1, 0)) + F.pad(values, (0, 1))).transpose(axis, 2)
    return both[:2] / both[2:].clamp(min=1)


def tidied(source: Tensor, free: Tensor, inside: Tensor) -> Tensor:
    """Source coordinates (2, H, W) without crumbs: a lone pixel that is free (H, W) joins the copy around it.

    inside (H, W): where there is texture; what is elsewhere has no influence. What is tidy already is returned bit for
    bit.
    """
    for _ in range(_ROUNDS):
        place = (free & _at_seams(source)).nonzero().T
        near, there = _around(source, inside, place)
        own = (there & _near(near - source[:, *place], 1)).sum(0)
        lone = own <= _FEW
        place, near, there = place[:, lone], near[:, :, lone], there[:, lone]
        alike = there[:, None] & there & _near(near[:, None] - near, 2)
        most, copy = alike.sum(1).max(0)
        joins = most > own[lone] + 1
        if not bool(joins.any()):
            break
        source = source.clone()
        source[:, *place[:, joins]] = near[copy[joins], :, joins.nonzero()[:, 0]].T
    return source


def softened(image: Tensor, source: Tensor, inside: Tensor, read: Callable[[Tensor], Tensor]) -> Tensor:
    """An image (C, H, W) whose pixels beside a seam show a little of the other copy too, continued to them.

    read: what the exemplar has at coordinates (2, N), (C, N). inside (H, W): where there is texture.
    """
    soft = image.clone()
    for step in _BESIDE:
        beside = _continued(source, step)
        seam = inside & _shifted(inside[None], step)[0] & ~_near(beside - source, 0)
        if bool(seam.any()):
            soft[:, seam] += _BLEED * (read(beside[:, seam]) - image[:, seam])
    return soft


def _at_seams(source: Tensor) -> Tensor:
    """Where (H, W) a pixel and one beside it belong to two copies."""
    (_, down), (_, right) = changes(offsets(source))
    seams = torch.zeros_like(source[0], dtype=torch.bool)
    seams[1:] |= ~down
    seams[:-1] |= ~down
    seams[:, 1:] |= ~right
    seams[:, :-1] |= ~right
    return seams


def _around(source: Tensor, inside: Tensor, place: Tensor) -> tuple[Tensor, Tensor]:
    """Where pixels at places (2, N), row first, are in the copies of the eight around them, (8, 2, N).

    It comes with where (8, N) there is texture; beyond the border is the border.
    """
    steps = torch.tensor(AROUND, device=source.device)[:, :, None]
    sides = torch.tensor(inside.shape, device=source.device)[:, None]
    beside = (place + steps).clamp(min=0).minimum(sides - 1)
    y, x = beside.unbind(1)
    return source[:, y, x].movedim(1, 0) - (beside - place).flip(1), inside[y, x]


def _continued(source: Tensor, step: tuple[int, int]) -> Tensor:
    """Where (2, H, W) each pixel is in the copy of the pixel `step` rows and columns away."""
    return _shifted(source, step) - torch.tensor(step[::-1], device=source.device).view(2, 1, 1)


def _near(change: Tensor, axis: int) -> Tensor:
    """Where a change of the offset, with its x and y along an axis, is small enough within one copy."""
    return change.square().sum(axis) < JUMP**2


def _shifted(values: Tensor, step: tuple[int, int]) -> Tensor:
    """For each pixel the values (C, H, W) of the one `step` rows and columns away; beyond the border, its own."""
    rows, columns = (
        (torch.arange(side, device=values.device) + by).clamp(0, side - 1)
        for side, by in zip(values.shape[1:], step, strict=True)
    )
    return values[:, rows][:, :, columns]
