"""Worn texture, and how it is renewed: what is worn, the blocks that are tried there, and the cuts that lay them."""

from flow.animation.renewing.renewal import Renewal
from flow.animation.renewing.scenes import places, places_onward
from flow.animation.renewing.stock import NOWHERE

__all__ = [
    "NOWHERE",
    "Renewal",
    "places",
    "places_onward",
]
