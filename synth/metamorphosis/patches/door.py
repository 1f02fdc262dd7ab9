"""`interpolate`: textures between two or more, the same everywhere or by a map, still or in time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import InputError, tensor_of, whole_sizes
from synth.metamorphosis.method import Frames, Report, silent
from synth.metamorphosis.methods import method as method_of
from synth.metamorphosis.patches.method import PatchMorph
from synth.metamorphosis.patches.weighting import Weighting, checked_weights
from synth.texture.form import Form, Image

Map = Tensor | np.ndarray


@dataclass(frozen=True)
class Interpolated(Generic[Image]):
    """What `interpolate` made.

    frames: images of the textures' kind, made when they are looked at. features: boolean maps (H, W) of where each
    texture's features are, as given or found. remarks: sentences on what was done.
    """

    frames: Frames[Image]
    features: tuple[Tensor, ...]
    remarks: tuple[str, ...]

    @property
    def image(self) -> Image:
        """The first frame."""
        return self.frames[0]


def interpolate(
    textures: Sequence[Image],
    weights: Sequence[float] | Sequence[Map],
    *,
    size: tuple[int, int] | None = None,
    features: Sequence[Map] | None = None,
    tile: bool = False,
    preset: str = "default",
    seed: int = 0,
    callback: Report | None = None,
    **options: Any,
) -> Interpolated[Image]:
    """Textures between two or more, by patches (Ruiters et al. 2010): the same everywhere, or each pixel its own.

    textures: images of one kind with the same number of channels, of any sizes: tensors (C, H, W), or arrays (H, W) or
    (H, W, C). weights: one for each texture, which are made to sum to 1; or a map for each frame of a film: weights
    (n, H, W) of the n textures, or of two textures how far (H, W) from the first to the second, 0 to 1. Where a map
    is the same as that of the frame before, so is the frame. size: (height, width) of frames, by default that of the
    maps, else of the first texture; maps are resized to it. features: for each texture a map (H, W) or (K, H, W) above
    a half where its features are; found by default. tile: frames repeat seamlessly. preset: "fast", "default" or
    "best". options: those of `PatchMorph`. callback: told what is being done, and how much of it is.

    Same seed, same bits, for any number of threads. Raises InputError for what cannot be used.
    """
    method = _method(preset, options)
    if size is not None:
        height, width = whole_sizes(size, 2, "the size of frames")
        size = (height, width)
    if len(textures) < 2:
        raise InputError(f"{len(textures)} texture was given; give at least two, between which others lie")
    form: Form[Image] = Form.of(list(textures))
    images = tuple(form.normalized(texture).cpu() for texture in textures)
    if any(image.ndim != 3 or len(image) != len(images[0]) for image in images):
        raise InputError("the textures are videos, or differ in their channels; give images that have all the same")
    if features is not None and len(features) != len(images):
        raise InputError(f"{len(features)} maps of features were given for {len(images)} textures; give one for each")
    maps = None if features is None else tuple(tensor_of(each).float() for each in features)
    count, shape, most = _looked_through(weights, images, size)
    between = method.between(images, maps, shape, tile, seed, most)
    report = callback or silent
    report("matching patches", 0.0)
    weightings = (_weighting(weights, number, images, size) for number in range(count))
    made = method.frames(between, weightings, count, report)
    frames = Frames((form.restored(frame.image) for frame in made), count)
    return Interpolated(frames, between.found.maps, method.remarks(between, count))


def _method(preset: str, options: dict[str, Any]) -> PatchMorph:
    found = method_of("patches", preset, options)
    assert isinstance(found, PatchMorph)
    return found


def _looked_through(
    weights: Sequence[float] | Sequence[Map], images: Sequence[Tensor], size: tuple[int, int] | None
) -> tuple[int, tuple[int, int], int]:
    """How many frames there are, their size, and how many weightings are told apart in one, at most.

    InputError for weights or maps that will not do. No more than one weighting is held.
    """
    if not len(weights):
        raise InputError("there are no weights; give one for each texture, or at least one map of them")
    count, most, shapes = len(weights) if _is_map(weights[0]) else 1, 1, set()
    for number in range(count):
        weighting = _weighting(weights, number, images, size)
        shapes.add(weighting.shape)
        most = max(most, len(weighting.palette))
    if len(shapes) > 1:
        raise InputError("the maps of a film differ in size; give all the same, or say the size of frames")
    return count, shapes.pop(), most


def _weighting(
    weights: Sequence[float] | Sequence[Map], number: int, images: Sequence[Tensor], size: tuple[int, int] | None
) -> Weighting:
    """The weighting of a frame; InputError for weights, or a map, that will not do."""
    given = weights[number]
    if not _is_map(given):
        own = (images[0].shape[1], images[0].shape[2])
        return Weighting.even(checked_weights([float(weight) for weight in weights], len(images)), size or own)
    values = tensor_of(given).float()
    if values.ndim == 2 and len(images) == 2:
        if not bool(((values >= 0) & (values <= 1)).all()):
            raise InputError("the map of how far from A to B has values that are not from 0 to 1; scale it first")
        values = torch.stack([1 - values, values])
    if values.ndim != 3 or len(values) != len(images):
        raise InputError(
            f"a map of weights has shape {tuple(values.shape)}; give ({len(images)}, H, W), a channel per texture"
        )
    if size is not None and tuple(values.shape[1:]) != size:
        values = F.interpolate(values[None], size, mode="bilinear", antialias=True)[0]
    return Weighting.of(values)


def _is_map(weight: float | Map) -> bool:
    """Whether it is a map of weights, or else one weight."""
    return isinstance(weight, (Tensor, np.ndarray)) and weight.ndim > 0
