"""Texture optimization: example-based synthesis as the minimization of one energy (Kwatra 2005)."""

from kwatra.errors import InputError
from kwatra.exemplar import Exemplar
from kwatra.histogram import match_histogram
from kwatra.levels import THESIS, Level, planned_levels, texture_element
from kwatra.measure import measure
from kwatra.metric import Feature, gradient
from kwatra.optimize import optimize
from kwatra.pixels import HardPixels, SoftPixels
from kwatra.prepared import Prepared
from kwatra.result import Progress, Result, Stage
from kwatra.settings import Settings
from kwatra.terms import Quadratic, Scaled, Sum, Term, TermLike
from kwatra.windows import Grid

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
