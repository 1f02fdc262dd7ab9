"""Seam costs as arrays, as compiled loops take them."""

from typing import NamedTuple

from kwatra.pieces.seams.stock import Array


class Prices(NamedTuple):
    """What `kwatra.pieces.SeamCost` makes of M between places of a mosaic, as arrays for compiled loops; of AXES axes.

    deep (N,): how deep in its element each place lies, of none where seams are not hidden; parts (N,): to which part it
    belongs, of none where that does not matter; hidden, least: as in `kwatra.pieces.Depth`. scales (AXES,): what M is
    multiplied by before it is divided by what `Steepness` says, of none for M alone; divisors (AXES,); slopes (AXES,
    N).
    """

    deep: Array
    parts: Array
    hidden: float
    least: float
    scales: Array
    divisors: Array
    slopes: Array
