"""Minimum cuts."""

from kwatra.cut.bands import along
from kwatra.cut.choices import FREE, KEEP, MOST, TAKE, VOID
from kwatra.cut.minimum import Costs, best_cut, seams_after, solved_at_once

__all__ = ["FREE", "KEEP", "MOST", "TAKE", "VOID", "Costs", "along", "best_cut", "seams_after", "solved_at_once"]
