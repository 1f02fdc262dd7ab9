"""Windows of an image, and how two are compared."""

from kwatra.windows.grid import Grid, channels_last, step_of, windows_at
from kwatra.windows.metric import Feature, Metric, gradient

__all__ = ["Feature", "Grid", "Metric", "channels_last", "gradient", "step_of", "windows_at"]
