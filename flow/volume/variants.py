"""Variants of a video whose texture moves as the flow asks, where the video's own does not (thesis section 7.3).

The search can only find motion that is there. So where the flow has directions that the video lacks, quarter turns of
the video bring them, which resample nothing; and where it has another speed, a scaled one does.
"""

import torch
from torch import Tensor

_MOVES = 0.25
"""Px a frame from which something moves."""

_ASKED, _HAS = 0.1, 0.02
"""A direction is asked for by this share of the vectors, and is there if this share has it."""

_ALIKE = 1.5
"""Speeds whose ratio is less are alike."""


def turns(own: Tensor, wanted: Tensor) -> tuple[float, ...]:
    """By how many degrees, counterclockwise, to turn a video that moves by `own` so that it moves as is wanted.

    Both (2, N), x first, in px per frame. Quarter turns, none where the video has all the directions already.
    """
    has, asked = _directions(own), _directions(wanted)
    found: list[float] = []
    lacking = (asked > _ASKED) & (has < _HAS)
    while bool(lacking.any()):
        # turned counterclockwise by one quarter, what moved down moves right
        gains = [float((asked * lacking * (has.roll(-quarter) >= _HAS)).sum()) for quarter in (1, 2, 3)]
        if max(gains) == 0:
            break
        quarter = 1 + gains.index(max(gains))
        found.append(90.0 * quarter)
        lacking &= has.roll(-quarter) < _HAS
    return tuple(sorted(found))


def scales(own: Tensor, wanted: Tensor) -> tuple[float, ...]:
    """The factor, from 1/2 to 2, by which to scale a video that moves by `own` for the speed nearest to what is wanted.

    None where their speeds are alike or nothing moves. Both (2, N), x first, in px per frame.
    """
    speeds = [flow.norm(dim=0) for flow in (own, wanted)]
    moving = [speed[speed > _MOVES] for speed in speeds]
    if not min(len(speed) for speed in moving):
        return ()
    ratio = float(moving[1].median() / moving[0].median())
    return () if 1 / _ALIKE < ratio < _ALIKE else (min(max(ratio, 0.5), 2.0),)


def _directions(flow: Tensor) -> Tensor:
    """The shares (4,) of vectors (2, N) that move right, down, left and up."""
    x, y = flow[:, flow.norm(dim=0) > _MOVES]
    quarter = torch.where(x.abs() >= y.abs(), torch.where(x > 0, 0, 2), torch.where(y > 0, 1, 3))
    counts = torch.bincount(quarter, minlength=4).float()
    return counts / counts.sum().clamp(min=1)
