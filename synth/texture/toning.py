"""Tones as a guide: a drawing whose light and dark the texture shows, by what of it is light and dark.

Soft pixels of a flat tone prefer the flattest windows of the texture. Here windows match the drawing by the exemplar
blurred, a channel of its own, so nothing of what is shown is made flatter.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar, InputError
from kwatra.base import over_channels
from kwatra.pieces import hidden_seams
from synth.texture.form import Form, Image, map_like

REACH, OF_ELEMENTS = 8.0, 0.5
"""How far around a pixel, in px, its tone is seen; where there are gaps between elements that is at least the second of
an element's size, as tones that change within it ask for parts. With 4 details of gravel and stones are a tenth
fainter, with 16 fewer of them follow. A wave of light and dark is shown 1.7 times as strongly by coins, stones, mosaics
and tiles of 30 to 40 pixels as by the drawing where all are seen within 8, .9 times by half their size; .64 of their
elements are cut, and .54."""

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
    form: Form[Any] = Form.of(images)
    maps: list[np.ndarray] = [
        ndimage.gaussian_filter(_gray(image), _reach(form.normalized(image)), mode="nearest", axes=(-2, -1))
        for image in images
    ]
    ends = np.quantile(np.concatenate([each.ravel() for each in maps]), (RARE, 1 - RARE))
    made = [map_like(wanted, values.astype(np.float32)) for values in (*maps, _gray(wanted).clip(*ends))]
    return made[:-1], made[-1]


def _reach(picture: Tensor) -> float:
    """How far around each pixel of a picture (C, *S) in [0, 1] its tone is seen, px."""
    hidden = hidden_seams(Exemplar.of(picture)) if picture.ndim == 3 else None
    return REACH if hidden is None else max(REACH, OF_ELEMENTS * hidden.size)


def _gray(image: Tensor | np.ndarray) -> np.ndarray:
    """The mean of an image's channels, (*S) float64."""
    if isinstance(image, Tensor):
        return (over_channels(image.detach().cpu().double()) / len(image)).numpy()
    values = np.asarray(image, np.float64)
    return values if values.ndim == 2 else values.mean(-1)
