"""Whether a texture's parts stay where they belong in the frame."""

import math
from collections.abc import Sequence

from kwatra import Exemplar, InputError, Stay, place_dependence
from kwatra.terms.stay import SCENE, STAYING
from synth.texture.light import lasting

LARGEST = 2.25
"""A scene stays the more the larger it is made, up to so many times its clip's area: larger ones were not tried."""

ENLARGED, LASTS = (2, 1), 0.85
"""By which power of that, the second of scenes whose light lasts by so much or more (`synth.texture.light.lasting`).
What lasts is seen at its place in every frame, so blocks from their own places show it side by side: of smoke, whose
light lasts by .93, columns stood beside each other half as large again. Four seeds of it score .081 with 2 and .077
with 1; of fish (.76) .068 and .065, but more than half as much is replayed again; two of a fountain (.75) .072 and
.077, of a waterfall (.42) .076 and .088. See also `kwatra.pieces.choosing.charges.LIKE`."""


def staying(stay: float | None, source: Exemplar, shape: Sequence[int], tile: bool) -> list[Stay]:
    """The term for a weight of staying in an output of some shape; None: decided for a video from the exemplar.

    That is by whether its statistics depend on the place. A scene that is made larger stays the more, by a power of how
    many times its area is the clip's: blocks, which are no larger, are else taken from beside their places, and rather
    from where the clip is dark and flat, which agrees with everything.
    """
    if stay is None:
        scene = not tile and place_dependence(source) >= SCENE
        stay = STAYING * _growth(source, shape) if scene else 0.0
    if stay > 0 and tile:
        raise InputError("what tiles has no places to stay at; leave out stay, or tile")
    return [Stay(stay)] if stay != 0 else []


def _growth(source: Exemplar, shape: Sequence[int]) -> float:
    """How many times more a scene stays in an output of some shape than at the size of an exemplar's largest frame."""
    larger = math.prod(shape[-2:]) / max(math.prod(picture.shape[-2:]) for picture in source.pictures())
    if larger <= 1:
        return 1.0
    return min(larger, LARGEST) ** ENLARGED[lasting(source).light >= LASTS]
