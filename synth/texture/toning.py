"""Tones as a guide: a drawing whose light and dark the texture shows, by what of it is light and dark.

Soft pixels of a flat tone prefer the flattest windows of the texture. Here windows match the drawing by the exemplar
blurred, a channel of its own, so nothing of what is shown is made flatter.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import InputError
from kwatra.base import over_channels
from synth.texture.form import Image

REACH = 8.0
"""How far around a pixel, in px, its tone is seen. With 4 details of gravel and stones are a tenth fainter, with 16
fewer of them follow."""

WEIGHT = 0.3
"""What such a guide counts beside the colors. A ramp from the darkest to the lightest tenth of stones, gravel, grass
and radishes is followed by .9 to 1.1, of bricks, which have but two tones, by .4; sharpness stays within a tenth."""

RARE = 0.1
"""So much of an exemplar is darker than a drawing may ask for, and so much lighter: of less the same would be shown
again and again."""


def tones(exemplars: Image | Sequence[Image], wanted: Image) -> tuple[list[Image], Image]:
    """The guide that asks for the tones of `wanted` where a texture is made of an exemplar, or several.

    All (H, W) or (H, W, C), or tensors (C, H, W), or videos with time before H, of one range of values; channels count
    alike. Returns maps of one channel, float: the exemplars' and the output's, see `synthesize`. Tones that the
    exemplars do not have are taken for the darkest or lightest they have. InputError for an array and a tensor.
    """
    images: list[Any] = list(exemplars) if isinstance(exemplars, (list, tuple)) else [exemplars]
    if any(isinstance(image, Tensor) != isinstance(wanted, Tensor) for image in images):
        raise InputError("tones are wanted of an array and a tensor; give both as one kind")
    maps: list[np.ndarray] = [
        ndimage.gaussian_filter(_gray(image), REACH, mode="nearest", axes=(-2, -1)) for image in images
    ]
    ends = np.quantile(np.concatenate([each.ravel() for each in maps]), (RARE, 1 - RARE))
    made = [_as(wanted, values) for values in (*maps, _gray(wanted).clip(*ends))]
    return made[:-1], made[-1]


def _gray(image: Tensor | np.ndarray) -> np.ndarray:
    """The mean of an image's channels, (*S) float64."""
    if isinstance(image, Tensor):
        return (over_channels(image.detach().cpu().double()) / len(image)).numpy()
    values = np.asarray(image, np.float64)
    return values if values.ndim == 2 else values.mean(-1)


def _as(like: Image, values: np.ndarray) -> Image:
    """A map (*S) as a tensor or an array of one channel."""
    made: Any = torch.from_numpy(values)[None].float() if isinstance(like, Tensor) else values[..., None]
    return made
