"""Frames of one texture under a film of masks, made by the engine.

Each frame starts from the one before: the places its pixels were copied from are carried along the motion of the
elements, and read again. Where they then have the mask that is wanted they stay. The engine has only to mend the rest,
with the mask as guidance: windows match on color and on mask. There a frame shows the pixels themselves that the engine
chose, not means of windows: it is as sharp as its source.
"""

from collections.abc import Iterator, Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.animation.carrying import carried
from flow.warps import Lookup, pixel_coordinates, warp
from kwatra import Exemplar, HardPixels, Level, Prepared, Settings, optimize
from synth.metamorphosis.textons.moving import Mask, MovingMasks
from synth.texture.guidance import Guide

_LEVELS = (Level(1, 8, 1),)
"""What has another mask is mended by one step with small windows. With a step of 16 px before it films of bricks,
stones, pebbles and terrazzo scored worse, by .02 to .07, when all pixels were open to it."""
_WEIGHT = 1.0
"""What the masks count beside the colors: as much."""


def guided(image: Tensor, mask: Mask, masks: MovingMasks, times: Sequence[float], seed: int) -> Iterator[Tensor]:
    """The texture of an image (C, H, W), whose mask (H, W) is that of the first time, under the mask of each time.

    The first frame is the image itself. times: in the order of the film, from the image on.
    """
    own = torch.from_numpy(mask)[None].float()
    weights = Guide([own], own, _WEIGHT).weights(len(image))
    prepared = Prepared(Exemplar.of([torch.cat([image, own])], weights=weights))
    framed = F.pad(own, (1, 1, 1, 1), value=-1)  # what lies beyond the image has neither mask
    where, everywhere = pixel_coordinates(image.shape[1:]), torch.ones_like(own[0], dtype=torch.bool)
    for before, now in zip((times[0], *times), times, strict=False):
        if now == times[0]:
            yield image
            continue
        wanted = torch.from_numpy(masks.at(now))
        where = carried(where, Lookup(masks.back(now, before), everywhere))
        guide = Guide([own], wanted[None].float(), _WEIGHT)
        start, right = warp(image, where, "bicubic").clamp(0, 1), warp(framed, where + 1, "nearest")[0] == wanted
        result = optimize(
            prepared,
            tuple(image.shape[1:]),
            settings=Settings(levels=_LEVELS),
            terms=guide.terms(HardPixels(start, right.expand_as(start)), len(image), "cpu"),
            start=guide.beside(start),
            seed=seed,
        )
        where = torch.where(right, where, result.where.flip(0).float())
        yield warp(image, where, "bicubic").clamp(0, 1)
