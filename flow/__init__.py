"""Motion: flow fields, warps and their file formats, and textures that flow along them."""

from flow.analytic import noise, rotation, saddle, shear, sink, source, stream, uniform, vortices, waves
from flow.fields import Field, resampled, sampled
from flow.unknown import filled
from flow.warps import Lookup, lookup, warp

__all__ = [
    "Field",
    "Lookup",
    "filled",
    "lookup",
    "noise",
    "resampled",
    "rotation",
    "saddle",
    "sampled",
    "shear",
    "sink",
    "source",
    "stream",
    "uniform",
    "vortices",
    "warp",
    "waves",
]
