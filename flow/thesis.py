"""Flowing textures as published (thesis algorithm 3), to compare with: the flow as a control term of the blend.

Every frame is the frame before it, warped, and then optimized by EM at one resolution with the flow term of equation
27. Colors are carried and windows averaged, so that texture blurs in time; `flow.animation` is the same energy without
that.
"""

from collections.abc import Iterator

import torch
from torch import Tensor

from flow.fields import Field
from flow.renewal import gradient_weight
from flow.unknown import filled
from flow.warps import Lookup, lookup, warp
from kwatra import Exemplar, Level, Prepared, Result, Settings, SoftPixels, optimize

_LEVELS = (Level(1, 16, iterations=2), Level(1, 8, iterations=2))


def flow_term(before: Tensor, look: Lookup, weight: float) -> SoftPixels:
    """The flow energy weight * (x - x+)^T K (x - x+) of a frame (thesis equation 27).

    x+ is the frame before, (C, H, W), warped by `look`; K the gradient weight of x+, 0 where nothing is known.
    """
    carried = filled(warp(before, look.coordinates), look.known)
    shares = torch.full((len(before), 1, 1), 1 / len(before), device=before.device)
    return SoftPixels(carried, (weight * gradient_weight(carried, shares) * look.known)[None], "flow")


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
