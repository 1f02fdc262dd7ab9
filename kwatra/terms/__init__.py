"""What else the output should be: control terms of the energy."""

from kwatra.terms.algebra import (
    Charge,
    PlaceCharge,
    Quadratic,
    Scaled,
    Sum,
    Term,
    TermLike,
    charge_of,
    parts_of,
    place_charge_of,
    within,
)
from kwatra.terms.controls import Controls, Given, Wish, check_controls, wish_of
from kwatra.terms.pixels import HardPixels, SoftPixels
from kwatra.terms.stay import Stay

__all__ = [
    "Charge",
    "Controls",
    "Given",
    "HardPixels",
    "PlaceCharge",
    "Quadratic",
    "Scaled",
    "SoftPixels",
    "Stay",
    "Sum",
    "Term",
    "TermLike",
    "Wish",
    "charge_of",
    "check_controls",
    "parts_of",
    "place_charge_of",
    "wish_of",
    "within",
]
