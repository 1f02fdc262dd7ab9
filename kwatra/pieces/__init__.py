"""Pieces of texture, laid along seams: where one fits, along which seam, and again where seams cost most."""

from kwatra.pieces.blocks import BlockStart
from kwatra.pieces.boxes import Box
from kwatra.pieces.cells import Cells, Fitted, cells_that_flow, find_cells, redrawn
from kwatra.pieces.choosing import Fit, totals
from kwatra.pieces.given import GivenCopies
from kwatra.pieces.seams import (
    HIDDEN,
    Depth,
    Gaps,
    Hidden,
    Mosaic,
    Parts,
    SeamCost,
    Stock,
    cheaper,
    find_gaps,
    found_coarser,
    hidden_along,
    hidden_seams,
    parts_of,
    visible_seams,
)
from kwatra.pieces.sheet import Budget, Cut, Patch, Regions, Sheet, lay_again
from kwatra.pieces.slanted import SlantedStart

__all__ = [
    "HIDDEN",
    "BlockStart",
    "Box",
    "Budget",
    "Cells",
    "Cut",
    "Depth",
    "Fit",
    "Fitted",
    "Gaps",
    "GivenCopies",
    "Hidden",
    "Mosaic",
    "Parts",
    "Patch",
    "Regions",
    "SeamCost",
    "Sheet",
    "SlantedStart",
    "Stock",
    "cells_that_flow",
    "cheaper",
    "find_cells",
    "find_gaps",
    "found_coarser",
    "hidden_along",
    "hidden_seams",
    "lay_again",
    "parts_of",
    "redrawn",
    "totals",
    "visible_seams",
]
