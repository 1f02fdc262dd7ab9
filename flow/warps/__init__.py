"""Pictures moved along a flow."""

from flow.warps.freeform import free_form
from flow.warps.seen import BORDER, end_point_error, seen
from flow.warps.unknown import filled
from flow.warps.warp import Lookup, lookup, pixel_coordinates, warp

__all__ = ["BORDER", "Lookup", "end_point_error", "filled", "free_form", "lookup", "pixel_coordinates", "seen", "warp"]
