"""Metamorphosis under texton masks (Tonietto and Walter 2005)."""

from synth.metamorphosis.textons.masks import checked, colored, found
from synth.metamorphosis.textons.method import TextonMorph
from synth.metamorphosis.textons.moving import MovingMasks

__all__ = ["MovingMasks", "TextonMorph", "checked", "colored", "found"]
