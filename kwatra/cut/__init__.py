"""Minimum cuts."""

from kwatra.cut.bands import along
from kwatra.cut.minimum import FREE, KEEP, TAKE, VOID, Costs, best_cut, seams_after

__all__ = ["FREE", "KEEP", "TAKE", "VOID", "Costs", "along", "best_cut", "seams_after"]
