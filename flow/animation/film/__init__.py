"""What flows, seen as one strip of frames: reading it, its own motion, its joints, and what lies beyond its frame."""

from flow.animation.film.drift import drift
from flow.animation.film.film import Film
from flow.animation.film.growing import grown
from flow.animation.film.reading import Reading, nearest_pixels, where_inside

__all__ = [
    "Film",
    "Reading",
    "drift",
    "grown",
    "nearest_pixels",
    "where_inside",
]
