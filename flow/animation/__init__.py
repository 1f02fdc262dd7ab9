"""Textures that flow.

What its constants were tried on: nuts and yellow bricks, 112 px wide, that turn by 2 px a frame, for 10 frames of 80x80
px, default preset, one seed. `kwatra.measure` (overall; lower is better) of three frames is .201 on average; what it is
with other values is said at each of them. Differences below .01 are noise. Those that concern videos alone were set
with `VIDEO_PRESETS`, on its three clips; where no more is said other values were not compared.
"""

from flow.animation.looping import loop
from flow.animation.sequence import Frame, animate
from flow.animation.settings import PRESETS, VIDEO_PRESETS, Renewing
from flow.animation.state import State
from flow.animation.term import flow_term
from flow.animation.thesis import published

__all__ = ["PRESETS", "VIDEO_PRESETS", "Frame", "Renewing", "State", "animate", "flow_term", "loop", "published"]
