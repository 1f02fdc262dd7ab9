"""Texture optimization: example-based synthesis as the minimization of one energy (Kwatra 2005)."""

from kwatra.base import InputError
from kwatra.exemplar import Exemplar
from kwatra.levels import THESIS, Level, planned_levels, texture_element
from kwatra.loop import optimize
from kwatra.measure import measure
from kwatra.result import Progress, Result, Stage
from kwatra.settings import Settings
from kwatra.source import Prepared
from kwatra.steps import match_histogram
from kwatra.terms import HardPixels, Quadratic, Scaled, SoftPixels, Sum, Term, TermLike
from kwatra.windows import Feature, Grid, gradient

__all__ = [
    "THESIS",
    "Exemplar",
    "Feature",
    "Grid",
    "HardPixels",
    "InputError",
    "Level",
    "Prepared",
    "Progress",
    "Quadratic",
    "Result",
    "Scaled",
    "Settings",
    "SoftPixels",
    "Stage",
    "Sum",
    "Term",
    "TermLike",
    "gradient",
    "match_histogram",
    "measure",
    "optimize",
    "planned_levels",
    "texture_element",
]
