"""Pieces of texture, laid along seams: where one fits, along which seam, and again where seams cost most."""

from kwatra.pieces.again import Budget, lay_again
from kwatra.pieces.blocks import BlockStart
from kwatra.pieces.boxes import Box
from kwatra.pieces.fitting import Fit, totals
from kwatra.pieces.gaps import Gaps, Hidden, gaps, hidden_along, hidden_seams
from kwatra.pieces.keeping import cheaper
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.regions import Regions
from kwatra.pieces.seams import Depth, SeamCost
from kwatra.pieces.sheet import Cut, Patch, Sheet
from kwatra.pieces.slanted import SlantedStart
from kwatra.pieces.stock import Stock
from kwatra.pieces.visible import visible_seams

__all__ = [
    "BlockStart",
    "Box",
    "Budget",
    "Cut",
    "Depth",
    "Fit",
    "Gaps",
    "Hidden",
    "Mosaic",
    "Patch",
    "Regions",
    "SeamCost",
    "Sheet",
    "SlantedStart",
    "Stock",
    "cheaper",
    "gaps",
    "hidden_along",
    "hidden_seams",
    "lay_again",
    "totals",
    "visible_seams",
]
