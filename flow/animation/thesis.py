"""Flowing textures as published, to compare with: the flow as a control term of the blend, windows averaged.

Of a picture (thesis algorithm 3) every frame is the frame before it, warped, and then optimized by EM at one resolution
with the flow term of equation 27. Of a video (section 7.1) all frames are unknown together: the engine minimizes the
texture's energy and that of equation 29 over the whole volume, and its search charges candidates by equation 31. It
begins with blocks that continue each other, where the thesis takes windows that flow as asked, whatever they look like:
those are flat ones, which flow as well as any. Colors are carried or averaged, so that texture blurs; `flow.animation`
is without that.
"""

from collections.abc import Iterator

import torch
from torch import Tensor

from flow.animation.film import drift
from flow.animation.term import flow_term
from flow.fields import Field
from flow.volume import VolumeFlow
from flow.volume.variants import scales, turns
from flow.warps import lookup
from kwatra import Exemplar, InputError, Level, Prepared, Result, Settings, optimize

_LEVELS = (Level(1, 16, iterations=2), Level(1, 8, iterations=2))

_WEIGHTS = {2: 0.5, 3: 0.3}
"""lambda, of pictures and of videos. A plume of smoke that turns kept .83 of its sharpness with .01, .67 with .3 and
.56 with 1, and was .85, .67 and .48 px off the flow. Begun with windows that flow as asked: .36 and
.71 px, with .01."""


def published(
    exemplar: Exemplar | Tensor,
    field: Field,
    shape: tuple[int, int],
    frames: int,
    weight: float | None = None,
    seed: int = 0,
    *,
    loop: bool = False,
    mask: Tensor | None = None,
) -> Iterator[Result]:
    """The frames, of `shape` (H, W), of thesis algorithm 3 or, of a video, of section 7.1.

    exemplar: an Exemplar, or a tensor (C, H, W) or (C, T, H, W); turned and scaled variants of a video's tensor serve
    where the flow asks for directions or speeds that it lacks (section 7.3). weight: lambda. loop, mask (H, W), True
    where texture belongs: for videos. Of a picture the first frame is, for the same seed, the one that `flow.animate`
    begins with where elements do not turn; a video's frames are made all at once, before the first is given.

    Raises InputError for a loop or a mask of a picture, or a video of fewer than 2 frames.
    """
    axes = len(exemplar.shape) if isinstance(exemplar, Exemplar) else exemplar.ndim - 1
    weight = _WEIGHTS[axes] if weight is None else weight
    if axes == 3:
        return _of_video(exemplar, field, (frames, *shape), weight, seed, loop, mask)
    if loop or mask is not None:
        raise InputError("as published, a picture's texture neither loops nor flows around obstacles; leave that out")
    exemplar = Exemplar.of(exemplar) if isinstance(exemplar, Tensor) else exemplar
    return _of_picture(exemplar, field, shape, frames, weight, seed)


def _of_picture(
    exemplar: Exemplar, field: Field, shape: tuple[int, int], frames: int, weight: float, seed: int
) -> Iterator[Result]:
    prepared = Prepared(exemplar)
    frame = optimize(exemplar, shape, seed=seed)
    yield frame
    for number in range(frames - 1):
        term = flow_term(frame.image, lookup(field(number, shape).to(frame.image.device)), weight)
        settings = Settings(levels=_LEVELS)
        frame = optimize(prepared, shape, settings=settings, terms=term, start=term.target, seed=seed)
        yield frame


def _of_video(
    exemplar: Exemplar | Tensor,
    field: Field,
    shape: tuple[int, int, int],
    weight: float,
    seed: int,
    loop: bool,
    mask: Tensor | None,
) -> Iterator[Result]:
    if shape[0] < 2:
        raise InputError(f"a video that flows as published is to have {shape[0]} frame; give at least 2")
    flows = torch.stack([field(number, shape[1:]) for number in range(shape[0] - (not loop))])
    exemplar = with_variants(exemplar, flows) if isinstance(exemplar, Tensor) else exemplar
    device = exemplar.canvas.device
    whole = None if mask is None else mask.to(device).expand(shape)
    return _made(exemplar, VolumeFlow(flows.to(device), weight, loop, mask=whole), shape, seed, whole)


def _made(
    exemplar: Exemplar, term: VolumeFlow, shape: tuple[int, int, int], seed: int, mask: Tensor | None
) -> Iterator[Result]:
    settings = Settings(wrap=(term.loop, False, False))
    made = optimize(exemplar, shape, settings=settings, terms=term, mask=mask, seed=seed)
    for number, image in enumerate(made.image.unbind(1)):
        yield Result(image, made.source[:, number], made.where[:, number], made.energies, [], made.stopped)


def with_variants(clip: Tensor, flows: Tensor) -> Exemplar:
    """An exemplar of a clip (C, T, H, W), with the variants of it that flows (N, 2, H, W) ask for."""
    plain = Exemplar.of(clip)
    own, wanted = drift(plain).flatten(1), flows.transpose(0, 1).flatten(1)
    turned, scaled = turns(own, wanted), scales(own, wanted)
    return Exemplar.of(clip, rotate=turned, scale=scaled) if turned or scaled else plain
