"""Detail that blends take away, given back where it belongs: the bands of the textures in between (see `bands`)."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from scipy.ndimage import maximum_filter
from torch import Tensor

from kwatra import Step
from synth.metamorphosis.bands import SETTLING, Bands
from synth.metamorphosis.patches.weighting import Weighting

_APART = 0.25
"""Weightings that are given bands of their own differ by so much."""

_ENOUGH = 400.0
"""Pixels that tell what bands a region has."""


@dataclass(frozen=True)
class Detail:
    """Bands, and for each where it counts, (H, W), summing to 1; None: a single one that counts everywhere.

    kept (H, W): pixels that stay as they are, or None.
    """

    bands: tuple[Bands, ...]
    shares: tuple[Tensor | None, ...]
    kept: Tensor | None = None

    @classmethod
    def of(cls, bands: Sequence[Bands], weighting: Weighting, kept: Tensor | None = None) -> "Detail":
        """That of textures with these bands, under a weighting."""
        if len(weighting.palette) == 1:
            return cls((Bands.among(bands, weighting.palette[0]),), (None,), kept)
        knots: list[Tensor] = []
        for weights in weighting.palette:
            there = torch.tensor(weights)
            if all(float((there - knot).abs().amax()) >= _APART for knot in knots):
                knots.append(there)
        near = [(weighting.values - k.view(-1, 1, 1)).square().sum(0).div(-(_APART**2)).exp() for k in knots]
        total = torch.stack(near).sum(0).clamp(min=1e-12)
        shares = [each / total for each in near]
        counted = [(k, s) for k, s in zip(knots, shares, strict=True) if float(s.sum()) >= _ENOUGH]
        rest = sum((s for _, s in counted), torch.zeros_like(total)).clamp(min=1e-12)
        return cls(
            tuple(Bands.among(bands, tuple(k.tolist())) for k, _ in counted), tuple(s / rest for _, s in counted), kept
        )

    def given_to(self, image: Tensor) -> Tensor:
        """An image (C, H, W) with the detail."""
        made = torch.zeros_like(image)
        for bands, share in zip(self.bands, self.shares, strict=True):
            made = bands.given_to(image) if share is None else made + share * bands.given_to(image, share)
        made = made if self.bands else image
        return made if self.kept is None else torch.where(self.kept, image, made)

    def settled(self, image: Tensor) -> Tensor:
        """A finished image (C, H, W) with the detail, in [0, 1]."""
        for _ in range(SETTLING):
            image = self.given_to(image).clamp(0, 1)
        return image

    def between(self, image: Tensor, step: Step) -> Tensor:
        """What `kwatra.optimize` applies after each blend: at full resolution, to colors; further channels stay."""
        if max(step.factors) > 1:
            return image
        count = len(self.bands[0].colors[0].center) if self.bands else 0
        return torch.cat([self.given_to(image[:count]), image[count:]]) if count else image


def dilated(mask: Tensor, reach: int) -> Tensor:
    """A mask (H, W), True also up to `reach` pixels away along either axis."""
    return torch.from_numpy(maximum_filter(mask.numpy(), 2 * reach + 1))
