"""Textures that flow."""

from flow.animation.looping import loop
from flow.animation.sequence import Frame, animate
from flow.animation.settings import PRESETS, VIDEO_PRESETS, Renewing
from flow.animation.state import State
from flow.animation.term import flow_term
from flow.animation.thesis import published

__all__ = ["PRESETS", "VIDEO_PRESETS", "Frame", "Renewing", "State", "animate", "flow_term", "loop", "published"]
