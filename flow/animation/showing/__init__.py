"""What is seen of a frame's copies: of a video, those that pass over into each other and those that fade."""

from flow.animation.showing.fading import Fading
from flow.animation.showing.mortar import Mortar
from flow.animation.showing.showing import Showing

__all__ = [
    "Fading",
    "Mortar",
    "Showing",
]
