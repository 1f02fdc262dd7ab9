"""Flow fields."""

from flow.fields.analytic import noise, rotation, saddle, shear, sink, source, stream, uniform, vortices, waves
from flow.fields.catalog import NAMES, named
from flow.fields.disc import disc, disc_mask
from flow.fields.field import Field, Shape, at_speed, resampled, sampled
from flow.fields.obstacles import around
from flow.fields.pictures import picture, wheel

__all__ = [
    "NAMES",
    "Field",
    "Shape",
    "around",
    "at_speed",
    "disc",
    "disc_mask",
    "named",
    "noise",
    "picture",
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
    "waves",
    "wheel",
]
