"""Which blocks of an exemplar are tried in a box: how well they agree with it, and what is charged for them."""

from kwatra.pieces.choosing.candidates import Asked, Candidates, Chosen
from kwatra.pieces.choosing.charges import SceneUse, StepCosts
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.fitting import Fit, totals
from kwatra.pieces.choosing.twins import NO_TWINS, twin_places
from kwatra.pieces.choosing.wished import Wished, unguided, variance

__all__ = [
    "NO_TWINS",
    "Asked",
    "Candidates",
    "Chosen",
    "Corners",
    "Fit",
    "SceneUse",
    "StepCosts",
    "Wished",
    "totals",
    "twin_places",
    "unguided",
    "variance",
]
