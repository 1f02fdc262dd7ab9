"""How good a texture is, and how much of it is copied (`kwatra.scoring.quality`)."""

from kwatra.scoring.copies import pasted
from kwatra.scoring.nearest import WINDOW
from kwatra.scoring.quality import measure
from kwatra.scoring.rough import CHANNELS, Ranking, glance

__all__ = ["CHANNELS", "WINDOW", "Ranking", "glance", "measure", "pasted"]
