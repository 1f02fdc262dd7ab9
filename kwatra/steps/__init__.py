"""The steps of an iteration: search, weights, votes and blend, and what may happen between."""

from kwatra.steps.asked import Wants
from kwatra.steps.blend import blend
from kwatra.steps.histogram import match_histogram
from kwatra.steps.inplace import fits
from kwatra.steps.matching import Matching
from kwatra.steps.replays import Replays
from kwatra.steps.robust import rho, weight
from kwatra.steps.seamvote import CheapestSeams
from kwatra.steps.votes import Ballot, Decisive, Mode, Pull, Vote, mean, winner

__all__ = [
    "Ballot",
    "CheapestSeams",
    "Decisive",
    "Matching",
    "Mode",
    "Pull",
    "Replays",
    "Vote",
    "Wants",
    "blend",
    "fits",
    "match_histogram",
    "mean",
    "rho",
    "weight",
    "winner",
]
