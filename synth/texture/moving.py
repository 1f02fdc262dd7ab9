"""Settings for textures that move."""

from dataclasses import replace

from kwatra import Decisive, Exemplar, Settings
from kwatra.base import mean

ROBUST = 0.4
"""The exponent r: windows of videos agree less. Of smoke with .8, as images have it, a sixth of the flicker that
belongs there is averaged away."""

BLOCK = 0.75
"""Blocks as a share of the clip's width and height, though at most half of the output's. What stays in its place ends
where blocks do, through the whole video: a waterfall half as large again had a straight seam from blocks of .5."""

USAGE = 1.0
"""How strongly the start avoids what was used: blocks match where little happens. Of rain made in code .90 of the
sharpness is left, .89 with .35 and .93 with 2, with which smoke flickers."""

NOTICED = 0.25
"""An edge is hardly seen that is so small a part of what changes from frame to frame anyway. Smoke, which changes
little, flickers 1.03 times as much as it should with .15, 1.09 times with .25, twice with no limit; a waterfall does
not need one."""


def in_time(settings: Settings, exemplar: Exemplar) -> Settings:
    """The settings for a video from clips: tuned on a waterfall, smoke and rain."""
    vote = Decisive(NOTICED * change(exemplar))
    return replace(settings, r=ROBUST, blocks=replace(settings.blocks, size=BLOCK, usage=USAGE), vote=vote)


def change(exemplar: Exemplar) -> float:
    """What changes from each frame to the next, rms over pixels and weighted channels; 0 of a single frame."""
    owner = exemplar.owner
    inside = (owner[1:] == owner[:-1]) & (owner[1:] >= 0)
    if not bool(inside.any()):
        return 0.0
    squared = (exemplar.canvas.diff(dim=1).square() * exemplar.share).sum(0)
    return float(mean(squared[inside])) ** 0.5
