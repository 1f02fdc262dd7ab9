"""Flowing textures as published (thesis algorithm 3), to compare with: the flow as a control term of the blend.

Every frame is the frame before it, warped, and then optimized by EM at one resolution with the flow term of equation
27. Colors are carried and windows averaged, so that texture blurs in time; `flow.animation` is the same energy without
that.
"""

from collections.abc import Iterator

from flow.animation.term import flow_term
from flow.fields import Field
from flow.warps import lookup
from kwatra import Exemplar, Level, Prepared, Result, Settings, optimize

_LEVELS = (Level(1, 16, iterations=2), Level(1, 8, iterations=2))


def published(
    exemplar: Exemplar, field: Field, shape: tuple[int, int], frames: int, weight: float = 0.5, seed: int = 0
) -> Iterator[Result]:
    """The frames of thesis algorithm 3; the first is the one that `flow.animate` begins with, for the same seed."""
    prepared = Prepared(exemplar)
    frame = optimize(exemplar, shape, seed=seed)
    yield frame
    for number in range(frames - 1):
        term = flow_term(frame.image, lookup(field(number, shape)), weight)
        settings = Settings(levels=_LEVELS)
        frame = optimize(prepared, shape, settings=settings, terms=term, start=term.target, seed=seed)
        yield frame
