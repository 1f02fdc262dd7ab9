"""Metamorphosis by optimal control: one velocity moves the texture while a source term changes its colors."""

from synth.metamorphosis.optimal_control.control import PRESETS, Control

__all__ = ["PRESETS", "Control"]
