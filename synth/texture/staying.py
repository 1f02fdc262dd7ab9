"""Whether a texture's parts stay where they belong in the frame."""

import math
from collections.abc import Sequence

from kwatra import Exemplar, InputError, Stay, place_dependence
from kwatra.terms.stay import SCENE, STAYING

LARGEST, ENLARGED = 2.25, 2
"""A scene stays the more the larger it is made, up to so many times its clip's area, larger ones were not tried; and by
which power of that. Half as large again smoke, fish and a waterfall scored .089, .078 and .081 with 2 (two seeds each),
.086, .077 and .084 with 1, and .96 and .97 of fish's and the waterfall's sharpness were left in place of .95; see also
`kwatra.pieces.charges.LIKE`."""


def staying(stay: float | None, source: Exemplar, shape: Sequence[int], tile: bool) -> list[Stay]:
    """The term for a weight of staying in an output of some shape; None: decided for a video from the exemplar.

    That is by whether its statistics depend on the place. A scene that is made larger stays the more, by a power of how
    many times its area is the clip's: blocks, which are no larger, are else taken from beside their places, and rather
    from where the clip is dark and flat, which agrees with everything.
    """
    if stay is None:
        scene = not tile and place_dependence(source) >= SCENE
        stay = STAYING * min(_enlarged(source, shape), LARGEST) ** ENLARGED if scene else 0.0
    if stay > 0 and tile:
        raise InputError("what tiles has no places to stay at; leave out stay, or tile")
    return [Stay(stay)] if stay != 0 else []


def _enlarged(source: Exemplar, shape: Sequence[int]) -> float:
    """How many times the area of the largest of an exemplar's frames an output's is, at least 1."""
    return max(math.prod(shape[-2:]) / max(math.prod(picture.shape[-2:]) for picture in source.pictures()), 1.0)
