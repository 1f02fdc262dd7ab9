"""At which resolution the optimization's start is laid, and of which blocks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from kwatra.base import factors_of
from kwatra.exemplar import Exemplar
from kwatra.pieces.blocks import BlockStart

if TYPE_CHECKING:
    from kwatra.loop.task import Task

LARGE = 160
"""Exemplars are halved until they have at most so many pixels across."""

LEAST = 8
"""Blocks are at least so many pixels wide, or as wide as the exemplar: smaller ones are thousands."""


def block_start(task: "Task", exemplar: Exemplar) -> tuple[Tensor, tuple[int, ...]]:
    """A source map of copied blocks and its resolution: the finest at which laying them costs little.

    Blocks agree with what the terms want; a mask only hides that, blocks run on behind it.
    """
    settings = task.settings
    coarsest = max(level.factor for level in task.levels)
    factor = 1
    while factor < coarsest and min(exemplar.extent[-2:]) / factor > LARGE:
        factor *= 2
    axes = len(task.shape)
    factors, grain = factors_of(factor, axes), factors_of(coarsest // factor, axes)
    here, controls = exemplar.coarser(factors), task.controls(factors)
    blocks = BlockStart(
        here,
        controls.shape,
        block_size(here, controls.shape, settings.block, grain),
        grain,
        task.generator,
        wraps=task.wraps,
        usage=settings.usage,
        aligned=settings.start == "aligned",
        seams=settings.seams,
        wish=controls.wish(torch.zeros(task.channels, *controls.shape, device=here.canvas.device)),
    )
    return blocks.run(), factors


def block_size(exemplar: Exemplar, shape: Sequence[int], share: float, grain: Sequence[int]) -> tuple[int, ...]:
    """Size of the blocks: `share` of the exemplar's extent, at most half of the output, a multiple of grain."""
    size = []
    for there, here, g in zip(exemplar.extent, shape, grain, strict=True):
        wanted = max(min(share * there, here / 2), LEAST)
        size.append(min(max(round(wanted / g) * g, g), there // g * g or there))
    return tuple(size)
