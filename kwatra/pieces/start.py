"""At which resolution the optimization's start is laid, and of which blocks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from kwatra.base import factors_of
from kwatra.elements import continued, find_lattice
from kwatra.exemplar import Exemplar
from kwatra.pieces.blocks import BlockStart

if TYPE_CHECKING:
    from kwatra.loop.task import Task

LARGE = 160
"""Exemplars are halved until they have at most so many pixels across."""

LOOKED_AT = 2**17
"""Exemplars with more pixels are not looked at for a period: that would take longer than laying their blocks."""

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


def repeated(task: "Task", exemplar: Exemplar) -> Tensor | None:
    """The source map (2, *shape), at full resolution, of an exactly periodic picture continued exactly.

    None where it is not periodic, or is to be something else.
    """
    plain = not task.terms and not any(task.wraps) and task.settings.start == "aligned" and len(task.shape) == 2
    fine = any(level.factor == 1 for level in task.levels)
    if not plain or not fine or exemplar.owner.numel() > LOOKED_AT:
        return None
    lattice = find_lattice(exemplar)
    return None if lattice is None else continued(exemplar, lattice, task.shape)


def block_size(exemplar: Exemplar, shape: Sequence[int], share: float, grain: Sequence[int]) -> tuple[int, ...]:
    """Size of the blocks: `share` of the exemplar's extent, at most half of the output, a multiple of grain."""
    size = []
    for there, here, g in zip(exemplar.extent, shape, grain, strict=True):
        wanted = max(min(share * there, here / 2), LEAST)
        size.append(min(max(round(wanted / g) * g, g), there // g * g or there))
    return tuple(size)
