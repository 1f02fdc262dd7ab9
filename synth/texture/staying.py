"""Whether a texture's parts stay where they belong in the frame."""

from kwatra import Exemplar, InputError, Stay, place_dependence
from kwatra.terms.stay import SCENE, STAYING


def staying(stay: float | None, source: Exemplar, tile: bool) -> list[Stay]:
    """The term for a weight of staying; None: decided for a video by whether its statistics depend on the place."""
    if stay is None:
        stay = STAYING if not tile and place_dependence(source) >= SCENE else 0.0
    if stay > 0 and tile:
        raise InputError("what tiles has no places to stay at; leave out stay, or tile")
    return [Stay(stay)] if stay != 0 else []
