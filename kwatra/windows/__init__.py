"""Windows of an image, where they lie, and how two are compared."""

from kwatra.windows.free import FreeWindows
from kwatra.windows.grid import Grid, channels_last, step_of, windows_at
from kwatra.windows.layout import Covering, Layout, per_axis
from kwatra.windows.metric import Feature, Metric, gradient

__all__ = [
    "Covering",
    "Feature",
    "FreeWindows",
    "Grid",
    "Layout",
    "Metric",
    "channels_last",
    "gradient",
    "per_axis",
    "step_of",
    "windows_at",
]
