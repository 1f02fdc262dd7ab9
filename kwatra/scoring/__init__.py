"""How good a texture is, and how much of it is copied (`kwatra.scoring.quality`)."""

from kwatra.scoring.nearest import WINDOW
from kwatra.scoring.quality import CHANNELS, glance, measure, rank

__all__ = ["CHANNELS", "WINDOW", "glance", "measure", "rank"]
