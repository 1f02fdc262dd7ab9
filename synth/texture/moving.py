"""Settings for textures that move."""

from dataclasses import replace

from kwatra import Decisive, Exemplar, Settings
from kwatra.base import mean, over_channels
from kwatra.elements import translation

ROBUST = 0.4
"""The exponent r: windows of videos agree less. Of smoke with .8, as images have it, a sixth of the flicker that
belongs there is averaged away."""

BLOCK = 0.62
"""Blocks as a share of the clip's width and height, though at most half of the output's. Of a scene made larger, large
blocks all show the clip's middle: with .75 a fountain half as large again shows .81 of its clip's gradients, with .6
.93. With .5 it shows more, but what stays in its place ends where blocks do, through the whole video, and smoke
is torn more: it scores .127 in place of .101. Three of .62 span half as large again, of .6 it takes four: of scenes
that stayed in proportion smoke then scored .089 and fish .080 in place of .086 and .077, .95 and .94 as sharp in place
of .98 and .95."""

PANNED = 1 / 3
"""The same for a clip that only translates: smaller blocks, used however often, find places where all goes on exactly.
Of 12 frames of 24x24 px .998 of the values of 24 frames move exactly, .78 with the others."""

NOTICED = 0.25
"""An edge is hardly seen that is so small a part of what changes from frame to frame anyway. Smoke, which changes
evenly, flickers 1.03 times as much as it should with .15, 1.09 times with .25, twice with no limit."""

HIDDEN = 4.0
"""So many times larger is an edge that is hardly seen where all that changes changes back at once: of a fountain, where
nothing is seen twice, .97 of the sharpness is left instead of .94."""


def in_time(settings: Settings, exemplar: Exemplar) -> Settings:
    """The settings for a video from clips: tuned on a waterfall, smoke and rain."""
    vote = Decisive(NOTICED * change(exemplar) * (1 + HIDDEN * undone(exemplar)))
    return replace(settings, r=ROBUST, block=PANNED if translation(exemplar) else BLOCK, vote=vote)


def change(exemplar: Exemplar) -> float:
    """What changes from each frame to the next, rms over pixels and weighted channels; 0 of a single frame."""
    owner = exemplar.owner
    inside = (owner[1:] == owner[:-1]) & (owner[1:] >= 0)
    if not bool(inside.any()):
        return 0.0
    squared = over_channels(exemplar.canvas.diff(dim=1).square() * exemplar.share)
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
