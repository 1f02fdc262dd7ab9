"""Metamorphosis by patterns: elements of A become elements of B (Liu, Liu, Shum and Yu 2002)."""

from synth.metamorphosis.patterns.detection import Detection, detect
from synth.metamorphosis.patterns.drawing import drawn
from synth.metamorphosis.patterns.finding import patterns_of
from synth.metamorphosis.patterns.landmarks import Patterns, patterns_writer, read_landmarks, read_patterns
from synth.metamorphosis.patterns.method import PatternMorph

__all__ = ["Detection", "PatternMorph", "Patterns", "detect", "drawn", "patterns_of", "patterns_writer",
           "read_landmarks", "read_patterns"]  # fmt: skip
