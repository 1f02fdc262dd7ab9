"""How much faster a texture changes across than along an axis: wood, hair and brushed metal run along one."""

import math

from kwatra.base import total
from kwatra.elements.correlation import pictures
from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar

STRAIGHT = 4.0
"""A still that changes so many times as fast across as along an axis is one of lines: what is laid may be of a line or
two. Wood that is slanted by 20 degrees, so that it reaches 2.5, got streaks."""

LONG, SLIM, SLIMMEST = 2.0, 0.25, 3
"""Windows on lines are so many times as long and as wide as others, at least so wide in pixels: each is then of a line
or two, and tells whether they go on. Set on two made woods and lines of blurred noise; half as wide ones do less."""

EASIEST = 64.0
"""A guard where nothing changes along a still, not tuned."""


@kept
def anisotropy(exemplar: Exemplar) -> float:
    """The root mean square difference of a still's pixels to the next on the right, over that to the next down.

    Above 1 the texture runs down, as the grain of a board that stands; below 1 it runs to the right. 1 for one color;
    infinite, or 0, where nothing changes along. What nobody owns is left out.
    """
    power, count = [0.0, 0.0], [0.0, 0.0]
    for picture, present in pictures(exemplar):
        for number, axis in enumerate((-1, -2)):
            sizes = picture.shape[axis] - 1
            both = present.narrow(axis, 0, sizes) * present.narrow(axis, 1, sizes)
            power[number] += float(total(picture.diff(dim=axis).square() * both))
            count[number] += float(total(both))
    right, down = (p / max(c, 1.0) for p, c in zip(power, count, strict=True))
    if down == 0:
        return 1.0 if right == 0 else math.inf
    return math.sqrt(right / down)


def runs_along(anisotropy: float, least: float) -> int | None:
    """The axis along which a still of some anisotropy runs: 0 down, 1 to the right.

    None where it changes less than `least` times as fast across as along.
    """
    if 1 / least < anisotropy < least:
        return None
    return 0 if anisotropy > 1 else 1


def drawn_sides(
    side: int, along: int | None, long: float = LONG, slim: float = SLIM, least: int = SLIMMEST
) -> tuple[int, int]:
    """The height and width of a square drawn out along an axis: so many times as long, and as wide; None: along none.

    It is at least so many px wide, or as wide as it was.
    """
    if along is None:
        return side, side
    length, width = round(long * side), min(max(round(slim * side), least), side)
    return (length, width) if along == 0 else (width, length)


def easier(anisotropy: float, along: int | None) -> tuple[float, float]:
    """By how many times less is seen of a seam that parts a still's pixels from those below, and from those beside.

    anisotropy: the still's. Where it runs along an axis (0 down, 1 to the right; None: nowhere) hardly a line goes on
    beyond what ends across it, and one that ends beside it parts what differs anyway: as many times less is seen as it
    changes faster there, at most EASIEST times.
    """
    if along is None:
        return 1.0, 1.0
    return (1.0, min(anisotropy, EASIEST)) if along == 0 else (1 / max(anisotropy, 1 / EASIEST), 1.0)
