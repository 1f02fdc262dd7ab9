"""The baselines: dissolving one texture into the other, as they are or registered."""

from synth.metamorphosis.blend.dissolve import Blend
from synth.metamorphosis.blend.registration import Registration

__all__ = ["Blend", "Registration"]
