"""Metamorphosis under texton masks (Tonietto and Walter 2005)."""

from synth.morph.textons.masks import checked, colored, found
from synth.morph.textons.method import TextonMorph
from synth.morph.textons.moving import MovingMasks

__all__ = ["MovingMasks", "TextonMorph", "checked", "colored", "found"]
