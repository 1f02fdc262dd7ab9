"""How good a texture is, and how much of it is copied."""

from kwatra.scoring.quality import measure

__all__ = ["measure"]
