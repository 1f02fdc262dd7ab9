"""Texture carried along a flow: source coordinates, the copies they form, and how these stay whole and upright."""

from flow.animation.carrying.blur import blurred
from flow.animation.carrying.coordinates import carried
from flow.animation.carrying.copies import (
    AROUND,
    JUMP,
    angle_of,
    angles,
    changes,
    distortion,
    onward,
    parted,
    replaced,
    rigid,
    softened,
    tidied,
    turned,
    turns,
)
from flow.animation.carrying.entering import SIDES, entered, enters, known_of
from flow.animation.carrying.overlapping import overlapped
from flow.animation.carrying.upright import Upright

__all__ = [
    "AROUND",
    "JUMP",
    "SIDES",
    "Upright",
    "angle_of",
    "angles",
    "blurred",
    "carried",
    "changes",
    "distortion",
    "entered",
    "enters",
    "known_of",
    "onward",
    "overlapped",
    "parted",
    "replaced",
    "rigid",
    "softened",
    "tidied",
    "turned",
    "turns",
]
