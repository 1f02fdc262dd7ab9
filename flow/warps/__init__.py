"""Pictures moved along a flow."""

from flow.warps.inverse import Lookup, lookup
from flow.warps.seen import BORDER, end_point_error, seen
from flow.warps.unknown import filled
from flow.warps.warp import Warp, pixel_coordinates, warp

__all__ = ["BORDER", "Lookup", "Warp", "end_point_error", "filled", "lookup", "pixel_coordinates", "seen", "warp"]
