"""Cells, each an element and the ground around it: what of copies they make whole."""

from kwatra.pieces.cells.fitting import bent, fitted, redrawn, softened
from kwatra.pieces.cells.shapes import Cells, cells_of, find_cells

__all__ = ["Cells", "bent", "cells_of", "find_cells", "fitted", "redrawn", "softened"]
