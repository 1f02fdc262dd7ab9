"""The baselines: dissolving one texture into the other, as they are or registered."""

from synth.morph.blend.dissolve import Blend
from synth.morph.blend.registration import Registration

__all__ = ["Blend", "Registration"]
