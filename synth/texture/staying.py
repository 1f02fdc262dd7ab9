"""Whether a texture's parts stay where they belong in the frame."""

from kwatra import Exemplar, InputError, Stay, place_dependence

STAYING = 0.3
"""The weight of staying where it is decided from the exemplar, chosen on a waterfall: with 1 more is replayed."""

SCENE = 0.5
"""From this dependence on the place on a clip is a scene: clips of water, fire, smoke and fish have .75 to 1."""


def staying(stay: float | None, source: Exemplar, tile: bool) -> list[Stay]:
    """The term for a weight of staying; None: decided for a video by whether its statistics depend on the place."""
    if stay is None:
        stay = STAYING if not tile and place_dependence(source) >= SCENE else 0.0
    if stay > 0 and tile:
        raise InputError("what tiles has no places to stay at; leave out stay, or tile")
    return [Stay(stay)] if stay != 0 else []
