"""Motion: flow fields, warps and their file formats, and textures that flow along them."""

from flow.analytic import noise, rotation, saddle, shear, sink, source, stream, uniform, vortices, waves
from flow.animation import Frame, State, animate
from flow.catalog import NAMES, named
from flow.disc import disc, disc_mask
from flow.fields import Field, at_speed, resampled, sampled
from flow.files import Recording, read_flow, write_flow
from flow.looping import loop
from flow.obstacles import around
from flow.pictures import picture, wheel
from flow.seen import end_point_error, seen
from flow.settings import PRESETS, Renewing
from flow.term import flow_term
from flow.thesis import published
from flow.unknown import filled
from flow.warps import Lookup, lookup, warp

__all__ = [
    "NAMES",
    "PRESETS",
    "Field",
    "Frame",
    "Lookup",
    "Recording",
    "Renewing",
    "State",
    "animate",
    "around",
    "at_speed",
    "disc",
    "disc_mask",
    "end_point_error",
    "filled",
    "flow_term",
    "lookup",
    "loop",
    "named",
    "noise",
    "picture",
    "published",
    "read_flow",
    "resampled",
    "rotation",
    "saddle",
    "sampled",
    "seen",
    "shear",
    "sink",
    "source",
    "stream",
    "uniform",
    "vortices",
    "warp",
    "waves",
    "wheel",
    "write_flow",
]
