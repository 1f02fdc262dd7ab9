"""Texture optimization: example-based synthesis as the minimization of one energy (Kwatra 2005)."""

from kwatra.base import InputError
from kwatra.elements import Lattice, element_size, find_lattice, place_dependence
from kwatra.exemplar import Exemplar
from kwatra.levels import THESIS, Level, planned_levels
from kwatra.loop import optimize
from kwatra.measure import measure
from kwatra.result import Progress, Result, Stage
from kwatra.settings import Settings
from kwatra.source import Bags, Prepared
from kwatra.steps import Ballot, CheapestSeams, Mode, Pull, Step, match_histogram, mean, regular, winner
from kwatra.terms import Charge, HardPixels, PlaceCharge, Quadratic, Scaled, SoftPixels, Stay, Sum, Term, TermLike
from kwatra.windows import Feature, FreeWindows, Grid, gradient

__all__ = [
    "THESIS",
    "Bags",
    "Ballot",
    "Charge",
    "CheapestSeams",
    "Exemplar",
    "Feature",
    "FreeWindows",
    "Grid",
    "HardPixels",
    "InputError",
    "Lattice",
    "Level",
    "Mode",
    "PlaceCharge",
    "Prepared",
    "Progress",
    "Pull",
    "Quadratic",
    "Result",
    "Scaled",
    "Settings",
    "SoftPixels",
    "Stage",
    "Stay",
    "Step",
    "Sum",
    "Term",
    "TermLike",
    "element_size",
    "find_lattice",
    "gradient",
    "match_histogram",
    "mean",
    "measure",
    "optimize",
    "place_dependence",
    "planned_levels",
    "regular",
    "winner",
]
