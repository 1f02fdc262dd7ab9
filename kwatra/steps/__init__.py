"""The steps of an iteration: search, weights, blend."""

from kwatra.steps.blend import blend
from kwatra.steps.histogram import match_histogram
from kwatra.steps.matching import Matching
from kwatra.steps.robust import rho, weight

__all__ = ["Matching", "blend", "match_histogram", "rho", "weight"]
