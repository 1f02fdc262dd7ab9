"""Texture optimization: example-based synthesis as the minimization of one energy (Kwatra 2005).

Names load when they are first used, so that `python -m kwatra` can speak before torch is there.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kwatra.base import InputError
    from kwatra.elements import (
        Lattice,
        Rows,
        direction_dependence,
        element_size,
        find_lattice,
        find_rows,
        place_dependence,
    )
    from kwatra.exemplar import Exemplar
    from kwatra.levels import THESIS, Level, planned_levels
    from kwatra.loop import Beginning, begin, improve, optimize
    from kwatra.result import Progress, Result, Stage
    from kwatra.scoring import measure
    from kwatra.settings import Settings, Solver
    from kwatra.source import Bags, Prepared
    from kwatra.step import Step, regular
    from kwatra.steps import Ballot, CheapestSeams, Decisive, Mode, Pull, match_histogram, mean, winner
    from kwatra.terms import Charge, HardPixels, PlaceCharge, Quadratic, Scaled, SoftPixels, Stay, Sum, Term, TermLike
    from kwatra.windows import Feature, FreeWindows, Grid, gradient

__all__ = [
    "THESIS",
    "Bags",
    "Ballot",
    "Beginning",
    "Charge",
    "CheapestSeams",
    "Decisive",
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
    "Rows",
    "Scaled",
    "Settings",
    "SoftPixels",
    "Solver",
    "Stage",
    "Stay",
    "Step",
    "Sum",
    "Term",
    "TermLike",
    "begin",
    "direction_dependence",
    "element_size",
    "find_lattice",
    "find_rows",
    "gradient",
    "improve",
    "match_histogram",
    "mean",
    "measure",
    "optimize",
    "place_dependence",
    "planned_levels",
    "regular",
    "winner",
]

_HOMES = {
    "Bags": "kwatra.source",
    "Ballot": "kwatra.steps",
    "Beginning": "kwatra.loop",
    "Charge": "kwatra.terms",
    "CheapestSeams": "kwatra.steps",
    "Decisive": "kwatra.steps",
    "Exemplar": "kwatra.exemplar",
    "Feature": "kwatra.windows",
    "FreeWindows": "kwatra.windows",
    "Grid": "kwatra.windows",
    "HardPixels": "kwatra.terms",
    "InputError": "kwatra.base",
    "Lattice": "kwatra.elements",
    "Level": "kwatra.levels",
    "Mode": "kwatra.steps",
    "PlaceCharge": "kwatra.terms",
    "Prepared": "kwatra.source",
    "Progress": "kwatra.result",
    "Pull": "kwatra.steps",
    "Quadratic": "kwatra.terms",
    "Result": "kwatra.result",
    "Rows": "kwatra.elements",
    "Scaled": "kwatra.terms",
    "Settings": "kwatra.settings",
    "Solver": "kwatra.settings",
    "SoftPixels": "kwatra.terms",
    "Stage": "kwatra.result",
    "Stay": "kwatra.terms",
    "Step": "kwatra.step",
    "Sum": "kwatra.terms",
    "THESIS": "kwatra.levels",
    "Term": "kwatra.terms",
    "TermLike": "kwatra.terms",
    "begin": "kwatra.loop",
    "direction_dependence": "kwatra.elements",
    "element_size": "kwatra.elements",
    "find_lattice": "kwatra.elements",
    "find_rows": "kwatra.elements",
    "gradient": "kwatra.windows",
    "improve": "kwatra.loop",
    "match_histogram": "kwatra.steps",
    "mean": "kwatra.steps",
    "measure": "kwatra.scoring",
    "optimize": "kwatra.loop",
    "place_dependence": "kwatra.elements",
    "planned_levels": "kwatra.levels",
    "regular": "kwatra.step",
    "winner": "kwatra.steps",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_HOMES[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
