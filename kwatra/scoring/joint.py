"""How far a texture's joint statistics are from the exemplar's: those of Portilla and Simoncelli, by plenoptic.

J. Portilla and E. P. Simoncelli, A parametric texture model based on joint statistics of complex wavelet coefficients,
2000: moments of brightness, how the bands of a steerable pyramid repeat in space, and how their magnitudes go together
across orientations and scales. They see what windows of 7 pixels do not: how elements lie, and how strong scales are.
"""

import warnings
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.scoring.nearest import one_thread

SIDES = (256, 128, 64)
"""Crops of so many pixels a side are looked at, the largest that fit: all of an image, by as few as cover it."""


class JointStatistics:
    """Those of images (C, H, W) of an exemplar, of crops of one of the SIDES."""

    @one_thread
    def __init__(self, images: Sequence[Tensor], side: int) -> None:
        self.side = side
        self.mean = _mean(images, side)

    @one_thread
    def distance(self, images: Sequence[Tensor]) -> float:
        """How far (L2) those of images are from these, relative to these; what is defined for one only is left out."""
        there = _mean(images, self.side)
        known = there.isfinite() & self.mean.isfinite()
        size = float(self.mean[known].norm())
        return float((there - self.mean)[known].norm()) / (size or 1.0)


def largest_side(images: Sequence[Tensor]) -> int | None:
    """The largest of SIDES that fits in all images (C, H, W), None if none does."""
    shortest = min(min(image.shape[1:]) for image in images)
    return next((side for side in SIDES if side <= shortest), None)


def _mean(images: Sequence[Tensor], side: int) -> Tensor:
    """The statistics of all crops of images, on average; of so many at a time as have the pixels of the largest."""
    model, crops = _model(side), torch.stack([crop for image in images for crop in _crops(image.mean(0), side)])
    with torch.no_grad():
        each = [model(several[:, None]).flatten(1) for several in crops.split((SIDES[0] // side) ** 2)]
    return torch.cat(each).mean(0)


def _crops(brightness: Tensor, side: int) -> list[Tensor]:
    """Crops (side, side) of an image (H, W), evenly spread, which cover it."""
    tops, lefts = (np.linspace(0, n - side, -(-n // side)).round().astype(int).tolist() for n in brightness.shape)
    return [brightness[top : top + side, left : left + side] for top in tops for left in lefts]


@lru_cache(maxsize=len(SIDES))
def _model(side: int) -> Any:
    """The model of crops of a side; with fewer scales where the coarsest would have no room for its correlations."""
    from plenoptic.models import PortillaSimoncelli  # takes a second: only where statistics are wanted

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return PortillaSimoncelli((side, side), n_scales=4 if side > SIDES[-1] else 3, spatial_corr_width=7)
