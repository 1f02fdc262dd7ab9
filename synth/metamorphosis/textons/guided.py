"""Frames of one texture under a film of masks, made by the engine.

Each frame starts from the one before: the places its pixels were copied from are carried along the motion of the
elements, and read again. The engine has only to mend what the motion tore, with the mask as guidance: windows match
on color and on mask. A frame shows the pixels themselves that the engine chose, not means of windows: it is as sharp as
its source.
"""

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from flow.animation.carrying import carried
from flow.warps import lookup, pixel_coordinates, warp
from kwatra import Exemplar, Level, Prepared, Settings, optimize
from synth.metamorphosis.textons.moving import Mask, MovingMasks
from synth.texture.guidance import Guide

_LEVELS = (Level(1, 8, 1),)
"""What the motion tore is mended by one step with small windows. With a step of 16 px before it more is made anew in
each frame. Of four pairs of photographs (bricks, stones, pebbles, terrazzo) the scores were .42 .30 .34 .43 with that
step and are .39 .28 .32 .36 without."""
_WEIGHT = 1.0


def guided(image: Tensor, mask: Mask, masks: MovingMasks, times: Sequence[float], seed: int) -> Iterator[Tensor]:
    """The texture of an image (C, H, W), whose mask (H, W) is that of the first time, under the mask of each time.

    The first frame is the image itself. times: in the order of the film, from the image on.
    """
    own = torch.from_numpy(mask)[None].float()
    weights = Guide([own], own, _WEIGHT).weights(len(image))
    prepared = Prepared(Exemplar.of([torch.cat([image, own])], weights=weights))
    where = pixel_coordinates(image.shape[1:])
    for before, now in zip((times[0], *times), times, strict=False):
        if now == times[0]:
            yield image
            continue
        guide = Guide([own], torch.from_numpy(masks.at(now))[None].float(), _WEIGHT)
        where = carried(where, lookup(masks.motion(before, now)))
        start = guide.beside(warp(image, where, "bilinear"))
        result = optimize(
            prepared,
            tuple(image.shape[1:]),
            settings=Settings(levels=_LEVELS),
            terms=guide.terms((), len(image), "cpu"),
            start=start,
            seed=seed,
        )
        where = result.where.flip(0).float()
        yield image[:, result.where[0], result.where[1]]
