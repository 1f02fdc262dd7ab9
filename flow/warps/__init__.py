"""Pictures moved along a flow."""

from flow.warps.freeform import REPEATS, free_form
from flow.warps.integration import again, displaced, displacement, followed, interpolated, jacobian
from flow.warps.inverse import Lookup, lookup
from flow.warps.seen import BORDER, end_point_error, seen
from flow.warps.smoothing import Smoothness
from flow.warps.unknown import filled
from flow.warps.warp import Warp, pixel_coordinates, warp

__all__ = [
    "BORDER",
    "REPEATS",
    "Lookup",
    "Smoothness",
    "Warp",
    "again",
    "displaced",
    "displacement",
    "end_point_error",
    "filled",
    "followed",
    "free_form",
    "interpolated",
    "jacobian",
    "lookup",
    "pixel_coordinates",
    "seen",
    "warp",
]
