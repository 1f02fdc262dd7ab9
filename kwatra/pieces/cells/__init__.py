"""Cells, each an element and the ground around it: what of copies they make whole."""

from kwatra.pieces.cells.fitting import Fitted, fitted, redrawn
from kwatra.pieces.cells.shapes import Cells, cells_of, cells_that_flow, find_cells

__all__ = ["Cells", "Fitted", "cells_of", "cells_that_flow", "find_cells", "fitted", "redrawn"]
