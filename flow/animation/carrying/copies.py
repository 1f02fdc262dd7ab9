"""Copies: the regions of a frame in which neighboring pixels show neighboring places of the exemplar.

Within a copy what pixels show moves on by a pixel from each to the next, in a direction that depends on how the copy is
turned, and little else; where two copies meet, it jumps. A carried seam frays, for each pixel keeps the copy that is
nearest: `tidied` takes the crumbs away, and `softened` shows the seam between two pixels as a camera would, with a
little of both.
"""

from collections.abc import Callable, Sequence

import numpy as np
import torch
from torch import Tensor

from kwatra.base import atan2

JUMP = 1.5
"""Neighboring pixels belong to two copies where what the second shows is so many px or more from where the first one's
copy goes on. Tried: .203 with 1, .199 with 2.5."""

NEIGHBORS = 2.0
"""Neighboring pixels that show places less than so many px apart tell how their copy is turned; exact copies show
neighbors. Not tuned."""

BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))
AROUND = (*BESIDE, (1, 1), (1, -1), (-1, 1), (-1, -1))
"""The steps, in rows and columns, to the eight pixels around one."""

_FEW = 2
"""A pixel is a crumb when no more than this many of the eight around it belong to its copy. Tried: .201 with 1,
.200 with 3."""

_ROUNDS = 8
"""So often crumbs are looked for, at most; those of larger ones that are left after that wait for the next frame."""

_BLEED = 0.125
"""What a pixel at a seam shows of each of the four beside it that belong to another copy. Tried: .202 with 0, .201 with
.2."""


def angles(source: Tensor, inside: Tensor | None = None) -> Tensor:
    """By how much each pixel's copy is turned in the exemplar, (H, W), in radians from x to y.

    It is the rotation next to the derivative of source coordinates (2, H, W), seen in the pixels around that show
    places less than NEIGHBORS px away; 0 where there are none. inside (H, W): where there is texture; what is elsewhere
    has no influence.
    """
    return angle_of(turned(source, inside))


def turned(source: Tensor, inside: Tensor | None = None) -> Tensor:
    """What copies change by to the right, (2, H, W), x first: the cosine and the sine of their `angles`."""
    from flow.animation.carrying.edges import tell_turns

    there = torch.ones_like(source[0], dtype=torch.bool) if inside is None else inside
    turn = torch.empty(source.shape, dtype=torch.float32)
    tell_turns(turn.shape[1], source.contiguous(), there.contiguous(), NEIGHBORS, turn)
    return turn.flip(0)


def angle_of(beside: Tensor) -> Tensor:
    """By how much copies are turned (*S) that change by so much to the right, (2, *S), x first."""
    return atan2(beside[1], beside[0])


def parted(source: Tensor, inside: Tensor, beside: Tensor, steps: Sequence[tuple[int, int]]) -> tuple[Tensor, Tensor]:
    """Where (n, H, W) the pixels so many steps away belong to other copies, and where those go on to here (n, 2, H, W).

    steps: rows and columns. beside (2, H, W): what copies change by to the right. inside (H, W): where there is
    texture.
    """
    from flow.animation.carrying.edges import find_seams

    seams, goes_on = (
        torch.empty(len(steps), *inside.shape, dtype=torch.bool),
        torch.empty(len(steps), *source.shape, dtype=torch.float32),
    )
    frame = (values.contiguous() for values in (source, inside, beside))
    find_seams(len(inside), *frame, np.array(steps), JUMP, seams, goes_on)
    return seams, goes_on


def rigid(angle: Tensor) -> tuple[Tensor, Tensor]:
    """What source coordinates change by a row down and a column to the right where copies are turned by an angle (*S).

    Both (2, *S), x first.
    """
    cos, sin = angle.cos(), angle.sin()
    return torch.stack([-sin, cos]), torch.stack([cos, sin])


def onward(place: Tensor, angle: Tensor, down: Tensor | float, right: Tensor | float) -> Tensor:
    """Where (2, *S), x first, copies that show a place (2, *S) go on so many rows down and columns to the right.

    angle: by which they are turned, (*S).
    """
    below, beside = rigid(angle)
    return place + down * below + right * beside


def changes(source: Tensor, angle: Tensor | None = None) -> tuple[tuple[Tensor, Tensor], tuple[Tensor, Tensor]]:
    """What source coordinates (2, H, W) change by from each pixel to the one below and to the one on its right, more
    than in a copy turned by `angle` (H, W), by default its own.

    Each, (2, H - 1, W) and (2, H, W - 1), comes with where the two pixels belong to one copy.
    """
    return _changes(source, *rigid(angles(source) if angle is None else angle))


def _changes(source: Tensor, below: Tensor, beside: Tensor) -> tuple[tuple[Tensor, Tensor], tuple[Tensor, Tensor]]:
    """As `changes`, where copies change by (2, H, W) from pixel to pixel."""
    down, right = source.diff(dim=1) - below[:, :-1], source.diff(dim=2) - beside[:, :, :-1]
    return (down, _near(down, 0)), (right, _near(right, 0))


def distortion(source: Tensor, beside: Tensor) -> Tensor:
    """How much more or less of the exemplar's area than its own each pixel shows, (H, W).

    It is the square of the determinant of the source's derivative less 1, at most 1; 0 between copies. Turning and
    shearing keep areas. beside (2, H, W): what copies change by to the right, as `turned` has it.
    """
    from flow.animation.carrying.edges import tell_area

    off = torch.empty_like(source[0])
    tell_area(len(off), source.contiguous(), beside.contiguous(), JUMP, off)
    return off


def turns(source: Tensor) -> Tensor:
    """What takes directions in the exemplar, x first, y down, to those of the pixels of its copies: (2, 2, H, W).

    It is the rotation next to the inverse of the derivative of source coordinates (2, H, W).
    """
    below, beside = rigid(angles(source))
    return torch.stack([beside, below])


def replaced(source: Tensor, before: Tensor) -> Tensor:
    """Where (H, W) source coordinates (2, H, W) show other copies than those before."""
    return (source - before).square().sum(0) >= JUMP**2


def tidied(source: Tensor, free: Tensor, inside: Tensor) -> Tensor:
    """Source coordinates (2, H, W) without crumbs: a lone pixel that is free (H, W) joins the copy around it.

    inside (H, W): where there is texture; what is elsewhere has no influence. What is tidy already is returned bit for
    bit.
    """
    from flow.animation.carrying.edges import tell_turns, tidy

    there, may = (values.contiguous() for values in (inside, free))
    turn, recent = torch.empty(source.shape, dtype=torch.float32), torch.ones_like(there)
    for _ in range(_ROUNDS):
        before, after, joined = (
            source.contiguous(),
            torch.empty(source.shape, dtype=torch.float32),
            torch.empty_like(there),
        )
        tell_turns(len(there), before, there, NEIGHBORS, turn)
        tidy(len(there), before, there, may, turn, np.array(AROUND), JUMP, _FEW, recent, after, joined)
        if not bool(joined.any()):
            break
        source, recent = after, joined
    return source


def softened(image: Tensor, source: Tensor, inside: Tensor, read: Callable[[Tensor], Tensor]) -> Tensor:
    """An image (C, H, W) whose pixels beside a seam show a little of the other copy too, continued to them.

    read: what the exemplar has at coordinates (2, N), (C, N). inside (H, W): where there is texture.
    """
    soft, shape = image.clone(), source.shape[1:]
    seams, goes_on = parted(source, inside, turned(source, inside), BESIDE)
    number, row, column = seams.nonzero().T
    beside = goes_on[number, :, row, column].T
    place = row * shape[1] + column
    for channel, change in zip(soft.flatten(1), _BLEED * (read(beside) - image.flatten(1)[:, place]), strict=True):
        channel.index_add_(0, place, change)  # in one dimension it adds in the order of the places
    return soft


def _near(change: Tensor, axis: int) -> Tensor:
    """Where a change of the offset, with its x and y along an axis, is small enough within one copy."""
    return change.square().sum(axis) < JUMP**2
