"""Holes in an image or video, filled with texture: from the rest of it, or from others like it.

The known pixels are hard ones and the rest of the image is an exemplar with a hole, so filling is synthesis with a
control term. Three things make it good: blocks that it begins with go on from what is known, as a part of the exemplar
that is laid already (`kwatra.pieces.given`); robust weights close to d^-2, by which nearly the best window takes all
(where much is known no window matches well, and a mean of many would be a blur); and what is done where copies meet
what is known (`synth.texture.closing`). Elements between which there is ground are completed first
(`kwatra.pieces.completion`). What runs along an axis, as wood does, is sewn of strips (`synth.texture.strips`), and the
lines of cloth go on by themselves (`synth.texture.cloth`).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import torch
from scipy.ndimage import distance_transform_edt
from torch import Tensor

import kwatra
from kwatra import Exemplar, HardPixels, InputError, Prepared, Progress, Result, element_size
from kwatra.base import tensor_of
from kwatra.levels import finishing
from kwatra.pieces import hidden_seams
from kwatra.scoring import WINDOW
from synth.texture.closing import Closing
from synth.texture.cloth import filled_by_lines
from synth.texture.form import Form, Image
from synth.texture.holes import box_around, check_channels, checked_hole, in_time, parts_to_fill
from synth.texture.illumination import find_light, under_even_light
from synth.texture.runs import seed_of, share_of
from synth.texture.strips import filled_by_strips, strips_along
from synth.texture.synthesis import Synthesis
from synth.texture.work import PRESETS

ROBUST = 0.1
"""The exponent r of the robust energy. Discs and scratches in rocks, bricks, grass, plaster, onyx, radishes, tomatoes
and a stone wall have .77 of the sharpness of what was there; .78 with .03, .76 with .3, .72 with .8, which suits whole
stills."""

MINDED = 0.01
"""How much more than other pixels known ones count in the search: the same discs have .90 of the sharpness of what was
there; .91 with 0, .88 with .03, and wide scratches .73 with each."""

BLOCK, BLOCK_IN_TIME = 0.25, 0.35
"""Size of the start's blocks as a share of the exemplar, the second of videos: in holes of a waterfall, fish and a
fountain .25 to .62 do as well, but of smoke .79 of the sharpness is left with .35, .58 with .25, .5 and .62."""

LARGEST = 64
"""They have at most so many pixels a side, or in a still as many as it is to what is known from where the hole is
deepest, up to half of the exemplar: in the middle of a large hole texture is as without one."""

DEEP = 0.5
"""Such a half. Eight pictures continued by 100 pixels on all sides score .050, .069 with blocks of `BLOCK`; what fills
discs of three tenths of six pictures' sides, seen alone, .147 and .179, and what was there .127. In discs of a fifth
all sizes do as well."""


def fill(
    image: Image,
    hole: Tensor | np.ndarray,
    *,
    exemplar: Image | Sequence[Image] | None = None,
    preset: str = "default",
    seed: int = 0,
    device: str = "cpu",
    callback: Callable[[Progress], None] | None = None,
) -> Synthesis[Image]:
    """The image or video with its hole filled by texture; pixels outside of the hole come back bit for bit.

    image: a tensor (C, H, W), or an array (H, W) or (H, W, C), as for `synthesize`; or a video (C, T, H, W), or
    (T, H, W, C). What it holds in the hole does not matter. hole: boolean (H, W), True where the image is to be
    filled; of a video (T, H, W), or (H, W) for a hole that is the same in all frames. exemplar: one or several images
    of its kind to fill from, instead of from its own rest. preset, seed, device, callback: as for `synthesize`; what
    runs along an axis is filled by strips, and cloth by its lines, whatever the preset.

    Where light falls unevenly on an image, what fills it comes under the light that is there.

    A still is filled from what is at most 256 pixels from the hole's bounding box, a video in parts of 24 frames, each
    from about a million pixels around it, so that a long one takes the memory of a short one. The result's `source`
    says where the filling comes from; known pixels come from themselves, or from nowhere (-1) where exemplars were
    given. Its `result` is of the part of the image around the hole that was worked on (last), under even light. Raises
    InputError for what cannot be used.
    """
    if preset not in PRESETS:
        raise InputError(f"the preset is {preset!r}; allowed are {', '.join(PRESETS)}")
    others: list[Any] = _listed(exemplar)
    missing: Tensor = checked_hole(image, in_time(image, tensor_of(hole).cpu()), bool(others))
    filled: Image = image.detach().cpu().clone() if isinstance(image, Tensor) else image.copy()
    pixels = planes_of(filled)
    pixels[:, missing.numpy()] = 0 if bool(missing.all()) else pixels[:, ~missing.numpy()][:, :1]
    given: list[Image] = [filled, *others]
    form: Form[Image] = Form.of(given)
    known = form.normalized(filled)
    check_channels(known, others)
    light = find_light(known, form.black, ~missing)
    even = known.clone() if light is None else light.without(known)
    where = np.indices((1, *missing.shape))[:, 0]
    where[0] = -1 if others else 0
    textures = list[Tensor]()
    if others:
        textures = under_even_light(Exemplar.of([*map(form.normalized, others)], device=device), form.black).pictures()
    made_of = partial(_made, others=textures, preset=preset, device=device)
    result = _in_parts(even, where, missing, made_of, bool(others), seed, callback)
    made = even[:, missing]
    made = made if light is None else light.at(missing.nonzero().unbind(1)).upon(made)
    pixels[:, missing.numpy()] = planes_of(form.restored(made[..., None]))[..., 0]
    return Synthesis(filled, where, result, replace(form, sizes=form.sizes[1:]) if others else form)


def _in_parts(
    image: Tensor,
    where: np.ndarray,
    missing: Tensor,
    made: Callable[..., tuple[Result, tuple[slice, ...]]],
    elsewhere: bool,
    seed: int,
    callback: Callable[[Progress], None] | None,
) -> Result:
    """Fill what is missing (*S) in an image (C, *S), and in where its pixels come from (1 + n, *S); the last result.

    made: `_made`, but for the part; elsewhere: whether other textures fill it.
    """
    parts = [*parts_to_fill(missing)]
    for number, (near, now) in enumerate(parts):
        told = None if callback is None else share_of(callback, number, len(parts))
        own = ~missing[near]
        own = own if own.sum() >= now.sum() else ~now  # then what was filled before is copied, too
        part = image[(slice(None), *near)]
        result, box = made(part, now, own, seed=seed_of(seed, number), callback=told)
        part[(slice(None), *box)][:, now[box]] = result.image.cpu()[:, now[box]]
        copied = result.source.cpu().numpy()[:, now[box].numpy()]
        if not elsewhere:
            copied = where[(slice(None), *(copied[1:] + np.array([[side.start] for side in near])))]
        where[(slice(None), *near)][:, now.numpy()] = copied
    return result


def _made(
    known: Tensor,
    missing: Tensor,
    own: Tensor,
    others: Sequence[Tensor],
    preset: str,
    seed: int,
    device: str,
    callback: Callable[[Progress], None] | None,
) -> tuple[Result, tuple[slice, ...]]:
    """The part of an image (C, *S) that holds the missing pixels (*S), filled, and where it lies.

    own (*S): what of the image may be copied, where there are no others to fill it from.
    """
    pictures, place = others, torch.from_numpy(np.indices(missing.shape))
    if others:
        source, place = _beside(others, known)
    else:
        pictures = _whole_parts(known, missing)
        source = Exemplar.of([known], masks=[own], device=device)
    still = missing.ndim == 2
    lines = None if not still or missing.all() else _by_lines(known, missing, source, not others, seed, callback)
    return lines or _filled(known, missing, source, pictures, place, preset, seed, callback)


def _by_lines(
    known: Tensor, missing: Tensor, source: Exemplar, own: bool, seed: int, callback: Callable[[Progress], None] | None
) -> tuple[Result, tuple[slice, ...]] | None:
    """The same as `_filled` has, where lines run that can be continued; own: whether the image itself is the source."""
    along = strips_along(source)
    if along is not None:
        return filled_by_strips(known, missing, source, along, seed, callback)
    cloth = filled_by_lines(known, missing, source, callback) if own else None
    return None if cloth is None else (cloth, (slice(None), slice(None)))


def _filled(
    known: Tensor,
    missing: Tensor,
    source: Exemplar,
    pictures: Sequence[Tensor],
    place: Tensor,
    preset: str,
    seed: int,
    callback: Callable[[Progress], None] | None,
) -> tuple[Result, tuple[slice, ...]]:
    """The part of an image (C, *S) that holds the missing pixels (*S) with a margin, filled, and where it lies.

    place (n, *S): where known pixels lie on the source's canvas.
    """
    settings, tries = PRESETS[preset]
    levels = finishing(kwatra.planned_levels(source, missing.shape, settings.iterations))
    settings = replace(settings, levels=levels, r=ROBUST, block=_block(missing, max(source.extent[-2:])))
    widest = levels[-1].window(missing.ndim)
    if missing.ndim == 2 and hidden_seams(source) is not None:
        widest = tuple(max(width, round(element_size(source))) for width in widest)
    box = box_around(missing, widest)
    device, there = source.canvas.device, place[(slice(None), *box)]
    image = known[(slice(None), *box)].to(device)
    rest = HardPixels(image, ~missing[box][None].to(device), weight=MINDED, source=there)
    return Closing(Prepared(source), rest, settings, tries, callback).best(seed, pictures), box


def _block(missing: Tensor, extent: int) -> float:
    """The size of blocks that fill what is missing (*S), as a share of an exemplar's longer side, px."""
    if missing.ndim > 2:
        return min(BLOCK_IN_TIME, LARGEST / extent)
    deep = math.inf if bool(missing.all()) else float(distance_transform_edt(missing.numpy()).max())
    return max(min(BLOCK, LARGEST / extent), min(deep / extent, DEEP))


def _whole_parts(image: Tensor, missing: Tensor) -> list[Tensor]:
    """What lies on the four sides of the missing pixels' bounding box, where it is large enough to be measured."""
    place = missing.nonzero()
    (top, left), (bottom, right) = place.amin(0).tolist()[-2:], (place.amax(0) + 1).tolist()[-2:]
    parts = image[..., :top, :], image[..., bottom:, :], image[..., :left], image[..., right:]
    return [part for part in parts if min(part.shape[-2:]) >= WINDOW]


def _beside(pictures: Sequence[Tensor], image: Tensor) -> tuple[Exemplar, Tensor]:
    """An exemplar of pictures, and an image (C, *S) of which nothing is copied; where it lies there, (n, *S)."""
    nothing = torch.zeros(image.shape[1:], dtype=torch.bool)
    both = Exemplar.of([*pictures, image], masks=[*[None] * len(pictures), nothing])
    first = (both.origin[0] == len(pictures)).nonzero()[0].cpu()
    return both, torch.from_numpy(np.indices(image.shape[1:])) + first.view(-1, *[1] * len(first))


def _listed(exemplar: Any) -> list[Any]:
    if exemplar is None:
        return []
    return [exemplar] if isinstance(exemplar, (Tensor, np.ndarray)) else list(exemplar)


def planes_of(image: Tensor | np.ndarray) -> np.ndarray:
    """The image's or video's own memory as an array, channels first."""
    if isinstance(image, Tensor):
        return image.numpy()
    return image[None] if image.ndim == 2 else np.moveaxis(image, -1, 0)
