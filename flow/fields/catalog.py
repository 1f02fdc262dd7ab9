"""Fields by name, for programs: `rotation`, `uniform:90`, `noise:7`."""

import math
from collections.abc import Callable

from flow.fields import analytic
from flow.fields.disc import disc
from flow.fields.field import Field
from kwatra.base import InputError

NAMES: dict[str, tuple[Callable[..., Field], str | None]] = {
    "uniform": (analytic.uniform, "angle"),
    "rotation": (analytic.rotation, None),
    "sink": (analytic.sink, None),
    "source": (analytic.source, None),
    "saddle": (analytic.saddle, "angle"),
    "shear": (analytic.shear, "angle"),
    "vortices": (analytic.vortices, "angle"),
    "stream": (analytic.stream, "angle"),
    "waves": (analytic.waves, "angle"),
    "noise": (analytic.noise, "seed"),
    "disc": (disc, "angle"),
}
"""By name: what makes the field, and what a number after the name means."""


def named(text: str, speed: float | None = None) -> Field:
    """The field that a text names: "NAME" or "NAME:NUMBER" (an angle in degrees, 0 right and 90 down; noise: a seed).

    speed: px per frame of the fastest pixel (default: 2). Raises InputError for a name that is none.
    """
    name, colon, number = text.partition(":")
    if name not in NAMES:
        raise InputError(f"{text!r} names no flow; give one of {', '.join(NAMES)}")
    make, meaning = NAMES[name]
    given = {} if speed is None else {"speed": speed}
    return make(**given, **_number(text, meaning, number) if colon else {})


def _number(text: str, meaning: str | None, number: str) -> dict[str, float]:
    if meaning is None:
        raise InputError(f"{text!r} has a number, but this flow takes none; leave it out")
    try:
        value = int(number) if meaning == "seed" else float(number)
    except ValueError:
        value = math.nan
    if not -math.inf < value < math.inf:  # of a number that may be longer than a float's
        raise InputError(f"{text!r} has no number for its {meaning}; write it as in uniform:90 or noise:7")
    return {meaning: value}
