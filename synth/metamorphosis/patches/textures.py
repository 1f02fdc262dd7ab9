"""A texture as neighborhoods are taken from it: at its own scale, and at the scale that all textures share."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra import Exemplar, element_size
from kwatra.base import coarse_shape, resized
from synth.metamorphosis.patches.feature_maps import distance_channel

LARGEST_RATIO = 2.0
"""Elements whose sizes differ by more are brought no closer than this: beyond, hardly a window would be left."""

_ALIKE = 1.15
"""Sizes that differ by less count as one: the estimate is no better."""


@dataclass(frozen=True)
class Texture:
    """An exemplar at one resolution.

    image (C, h, w). distance (1, h, w): see `feature_maps.distance_channel`. features (h, w): boolean, where they lie.
    unit: how many of its pixels make one at the common scale.
    """

    image: Tensor
    distance: Tensor
    features: Tensor
    unit: float

    @classmethod
    def of(cls, image: Tensor, features: Tensor, unit: float, factor: int) -> "Texture":
        """The texture of an image (C, H, W) and its feature map, `factor` times coarser."""
        factors, shape = (factor, factor), coarse_shape(image.shape[1:], (factor, factor))
        distance = distance_channel(features).to(image)
        coarse, away = (resized(each, factors, shape) for each in (image, distance))
        return cls(coarse, away, placed(features, shape), unit)

    @property
    def channels(self) -> Tensor:
        """Colors and distance, (C + 1, h, w)."""
        return torch.cat([self.image, self.distance])

    def common(self) -> "Texture":
        """The same at the common scale."""
        if self.unit == 1:
            return self
        shape = tuple(round(side / self.unit) for side in self.image.shape[1:])
        image, distance = (at_size(each, shape) for each in (self.image, self.distance))
        return Texture(image, distance, placed(self.features, shape), 1.0)


def common_units(images: Sequence[Tensor]) -> tuple[float, ...]:
    """How many pixels of each texture make one of a common scale, at which their elements have one size."""
    logs = np.log([element_size(Exemplar.of(image)) for image in images])
    apart = np.ptp(logs)
    if apart < np.log(_ALIKE):
        return (1.0,) * len(images)
    logs = (logs - logs.mean()) * min(1.0, np.log(LARGEST_RATIO) / apart)
    return tuple(float(unit) for unit in np.exp(logs))


def at_size(image: Tensor, shape: Sequence[int]) -> Tensor:
    """An image (C, H, W) at another size (height, width)."""
    if tuple(image.shape[1:]) == tuple(shape):
        return image
    return F.interpolate(image[None], tuple(shape), mode="bilinear", antialias=True)[0]


def placed(features: Tensor, shape: Sequence[int]) -> Tensor:
    """Feature pixels (H, W) on a grid of another size (height, width): the same points."""
    found = torch.zeros(tuple(shape), dtype=torch.bool)
    lines = zip(features.cpu().nonzero(as_tuple=True), features.shape, shape, strict=True)
    found[tuple(((line + 0.5) * to / of).long() for line, of, to in lines)] = True
    return found
