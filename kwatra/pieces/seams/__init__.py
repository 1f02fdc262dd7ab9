"""Seams: what copies of a stock cost where they meet, where gaps hide that, and how much of it is seen."""

from kwatra.pieces.seams.cost import HIDDEN, NORMALIZED_SCALE, Depth, SeamCost, eased, normalized, summed
from kwatra.pieces.seams.gaps import Gaps, Hidden, find_gaps, found_coarser, hidden_along, hidden_seams
from kwatra.pieces.seams.keeping import cheaper
from kwatra.pieces.seams.mosaic import LEVELS, Mosaic, by_place
from kwatra.pieces.seams.parts import Parts, parts_of
from kwatra.pieces.seams.prices import Prices
from kwatra.pieces.seams.stock import Array, Matches, Stock, beside, each
from kwatra.pieces.seams.visible import visible_seams

__all__ = [
    "HIDDEN",
    "LEVELS",
    "NORMALIZED_SCALE",
    "Array",
    "Depth",
    "Gaps",
    "Hidden",
    "Matches",
    "Mosaic",
    "Parts",
    "Prices",
    "SeamCost",
    "Stock",
    "beside",
    "by_place",
    "cheaper",
    "each",
    "eased",
    "find_gaps",
    "found_coarser",
    "hidden_along",
    "hidden_seams",
    "normalized",
    "parts_of",
    "summed",
    "visible_seams",
]
