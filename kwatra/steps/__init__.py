"""The steps of an iteration: search, weights, blend."""

from kwatra.steps.blend import blend, conjugate_gradients
from kwatra.steps.histogram import match_histogram
from kwatra.steps.matching import Matching
from kwatra.steps.robust import rho, weight

__all__ = ["Matching", "blend", "conjugate_gradients", "match_histogram", "rho", "weight"]
