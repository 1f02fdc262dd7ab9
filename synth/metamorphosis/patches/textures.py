"""A texture as neighborhoods are taken from it: at its own scale, and at the scale that all textures share."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import coarse_shape, resized
from synth.metamorphosis.patches.feature_maps import distance_channel


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

    def common(self, shape: Sequence[int] | None = None) -> "Texture":
        """The same at the common scale; shape: its (height, width) there, by default as the unit says."""
        if self.unit == 1:
            return self
        shape = shape or tuple(round(side / self.unit) for side in self.image.shape[1:])
        image, distance = (at_size(each, shape) for each in (self.image, self.distance))
        return Texture(image, distance, placed(self.features, shape), 1.0)


def at_size(image: Tensor, shape: Sequence[int]) -> Tensor:
    """An image (C, H, W) at another size (height, width)."""
    if tuple(image.shape[1:]) == tuple(shape):
        return image
    return F.interpolate(image[None], tuple(shape), mode="bilinear", antialias=True)[0]


def placed(features: Tensor, shape: Sequence[int]) -> Tensor:
    """Feature pixels (H, W) on a grid of another size (height, width): the same points."""
    found = torch.zeros(tuple(shape), dtype=torch.bool)
    lines = zip(features.nonzero(as_tuple=True), features.shape, shape, strict=True)
    found[tuple(((line.float() + 0.5) * to / of).long() for line, of, to in lines)] = True
    return found
