"""The sheet that patches are laid on: its seams, regions that need a patch, the one that is laid, and laying again."""

from kwatra.pieces.sheet.again import Budget, lay_again
from kwatra.pieces.sheet.cheapest import Offer, cheapest_as_offered, cheapest_cuts, patch_of
from kwatra.pieces.sheet.cuts import Cut, Cuts, Patch
from kwatra.pieces.sheet.regions import Regions
from kwatra.pieces.sheet.sheet import Sheet
from kwatra.pieces.sheet.window import Window, Windows

__all__ = [
    "Budget",
    "Cut",
    "Cuts",
    "Offer",
    "Patch",
    "Regions",
    "Sheet",
    "Window",
    "Windows",
    "cheapest_as_offered",
    "cheapest_cuts",
    "lay_again",
    "patch_of",
]
