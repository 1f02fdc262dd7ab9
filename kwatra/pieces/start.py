"""At which resolution the optimization's start is laid, and of which blocks."""

from collections.abc import Sequence

import torch
from torch import Tensor

from kwatra.base import factors_of
from kwatra.exemplar import Exemplar
from kwatra.levels import Level
from kwatra.pieces.blocks import BlockStart
from kwatra.settings import Settings
from kwatra.terms import Controls, TermLike

LARGE = 160
"""Exemplars are halved until they have at most so many pixels across."""

LEAST = 8
"""Blocks are at least so many pixels wide, or as wide as the exemplar: smaller ones are thousands."""


def block_start(
    exemplar: Exemplar,
    shape: tuple[int, ...],
    levels: Sequence[Level],
    settings: Settings,
    generator: torch.Generator,
    terms: Sequence[TermLike] = (),
    mask: Tensor | None = None,
) -> tuple[Tensor, tuple[int, ...]]:
    """A source map of copied blocks and its resolution: the finest at which laying them costs little.

    Blocks agree with what the terms want; a mask only hides that, blocks run on behind it.
    """
    axes = len(shape)
    coarsest = max(level.factor for level in levels)
    factor = 1
    while factor < coarsest and min(exemplar.extent[-2:]) / factor > LARGE:
        factor *= 2
    factors, grain = factors_of(factor, axes), factors_of(coarsest // factor, axes)
    here = exemplar.coarser(factors)
    controls = Controls(terms, mask, factors, shape, len(here.weights), here.canvas.device)
    there = controls.shape
    wish = controls.wish(torch.zeros(len(here.weights), *there, device=here.canvas.device))
    block = block_size(here, there, settings.block, grain)
    aligned = settings.start == "aligned"
    blocks = BlockStart(
        here,
        there,
        block,
        grain,
        generator,
        wrap=settings.wrap,
        usage=settings.usage,
        aligned=aligned,
        seams=settings.seams,
        wish=wish,
    )
    return blocks.run(), factors


def block_size(exemplar: Exemplar, shape: Sequence[int], share: float, grain: Sequence[int]) -> tuple[int, ...]:
    """Size of the blocks: `share` of the exemplar's extent, at most half of the output, a multiple of grain."""
    size = []
    for there, here, g in zip(exemplar.extent, shape, grain, strict=True):
        wanted = max(min(share * there, here / 2), LEAST)
        size.append(min(max(round(wanted / g) * g, g), there // g * g or there))
    return tuple(size)
