"""Settings for textures that move."""

from dataclasses import replace

import torch
from torch import Tensor

from kwatra import Decisive, Exemplar, Settings
from kwatra.base import mean

ROBUST = 0.4
"""The exponent r: windows of videos agree less. Of smoke with .8, as images have it, a sixth of the flicker that
belongs there is averaged away."""

BLOCK = 0.75
"""Blocks as a share of the clip's width and height, though at most half of the output's. What stays in its place ends
where blocks do, through the whole video: a waterfall half as large again had a straight seam from blocks of .5."""

PANNED = 1 / 3
"""The same for a clip that only translates: smaller blocks, used however often, find places where all goes on exactly.
Of 12 frames of 24x24 px .998 of the values of 24 frames move exactly, .78 with the others."""

USAGE = 1.0
"""How strongly the start avoids what was used: blocks match where little happens. Of rain made in code .90 of the
sharpness is left, .89 with .35 and .93 with 2, with which smoke flickers."""

NOTICED = 0.25
"""An edge is hardly seen that is so small a part of what changes from frame to frame anyway. Smoke, which changes
evenly, flickers 1.03 times as much as it should with .15, 1.09 times with .25, twice with no limit."""

HIDDEN = 4.0
"""So many times larger is an edge that is hardly seen where all that changes changes back at once: of a fountain, where
nothing is seen twice, .97 of the sharpness is left instead of .94."""


def in_time(settings: Settings, exemplar: Exemplar) -> Settings:
    """The settings for a video from clips: tuned on a waterfall, smoke and rain."""
    vote = Decisive(NOTICED * change(exemplar) * (1 + HIDDEN * undone(exemplar)))
    size, usage = (PANNED, 0.0) if translation(exemplar) else (BLOCK, USAGE)
    return replace(settings, r=ROBUST, blocks=replace(settings.blocks, size=size, usage=usage), vote=vote)


def translation(exemplar: Exemplar) -> tuple[int, int] | None:
    """The whole pixels (down, right) by which every frame of a single clip is the one before it, moved, to the bit.

    None where there is no such motion, where it is 0, or where it leaves less than half of the frame to be seen.
    """
    from skimage.registration import phase_cross_correlation  # stills need none of it

    canvas = exemplar.canvas
    if canvas.shape[1] < 2 or not bool((exemplar.owner == 0).all()):
        return None
    first, second = (canvas[:, number].mean(0).cpu().numpy() for number in (0, 1))
    if first.min() == first.max() or second.min() == second.max():
        return None
    shift = phase_cross_correlation(first - first.mean(), second - second.mean())[0]
    down, right = (-round(float(by)) for by in shift)
    height, width = canvas.shape[2:]
    if (down, right) == (0, 0) or abs(down) > height // 2 or abs(right) > width // 2:
        return None
    before, after = _overlap(canvas[:, :-1], down, right), _overlap(canvas[:, 1:], -down, -right)
    return (down, right) if torch.equal(before, after) else None


def _overlap(frames: Tensor, down: int, right: int) -> Tensor:
    """What of frames (..., H, W) is still seen when they have moved."""
    height, width = frames.shape[-2:]
    rows = slice(max(-down, 0), height - max(down, 0))
    return frames[..., rows, max(-right, 0) : width - max(right, 0)]


def change(exemplar: Exemplar) -> float:
    """What changes from each frame to the next, rms over pixels and weighted channels; 0 of a single frame."""
    owner = exemplar.owner
    inside = (owner[1:] == owner[:-1]) & (owner[1:] >= 0)
    if not bool(inside.any()):
        return 0.0
    squared = (exemplar.canvas.diff(dim=1).square() * exemplar.share).sum(0)
    return float(mean(squared[inside])) ** 0.5


def undone(exemplar: Exemplar) -> float:
    """How much of what changes changes back in the next frame, 0 to 1: -2 times the correlation of successive changes.

    1 where frames know nothing of each other; 0 where changes go on as often as not, and of fewer than 3 frames.
    """
    owner, steps = exemplar.owner, exemplar.canvas.diff(dim=1)
    inside = (owner[2:] == owner[:-2]) & (owner[1:-1] == owner[2:]) & (owner[2:] >= 0)
    if not bool(inside.any()):
        return 0.0
    before, after = (part * exemplar.share.sqrt() for part in (steps[:, :-1], steps[:, 1:]))
    products = [
        mean((one * other).sum(0)[inside]) for one, other in ((before, after), (before, before), (after, after))
    ]
    both, size = float(products[0]), float(products[1] + products[2]) / 2
    return min(max(-2 * both / size, 0.0), 1.0) if size > 0 else 0.0
