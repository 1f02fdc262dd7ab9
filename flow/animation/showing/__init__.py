"""What is seen of a frame's copies: those of a video pass over into each other, or fade; a torn wall has mortar."""

from flow.animation.showing.fading import Fading
from flow.animation.showing.mortar import Mortar
from flow.animation.showing.showing import Showing

__all__ = [
    "Fading",
    "Mortar",
    "Showing",
]
