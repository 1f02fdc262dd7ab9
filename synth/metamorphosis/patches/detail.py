"""Detail that blends take away, given back where it belongs (section 4.5)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from scipy.ndimage import gaussian_filter, maximum_filter
from torch import Tensor

from kwatra import Step
from synth.metamorphosis.patches.neighborhoods import Weights
from synth.metamorphosis.patches.weighting import Weighting
from synth.metamorphosis.recolor import Colors, barycenter

Restoring = Callable[[Tensor, Tensor | None], Tensor]
"""Gives an image (C, H, W) the detail of a texture; the second argument: how much each pixel (H, W) counts, or None."""

_APART = 0.25
"""Weightings that are given detail of their own differ by so much."""

_ENOUGH = 400.0
"""Pixels that tell what detail a region has."""


@dataclass(frozen=True)
class Detail:
    """What restores detail, and for each where it counts, (H, W), summing to 1; None: a single one, everywhere.

    told: for each how much of an image's own detail each pixel (H, W) tells; None: all alike. shifts: for each the mean
    color (C, H, W) that is due at each pixel, less that of its own texture, or None. kept (H, W): pixels that stay as
    they are, or None.
    """

    restoring: tuple[Restoring, ...]
    shares: tuple[Tensor | None, ...]
    told: tuple[Tensor | None, ...]
    shifts: tuple[Tensor | None, ...]
    kept: Tensor | None = None

    @classmethod
    def of(
        cls,
        among: Callable[[Weights], Restoring],
        center: Callable[[Weights], Tensor],
        weighting: Weighting,
        kept: Tensor | None = None,
        inside: Tensor | None = None,
    ) -> "Detail":
        """That of a weighting; among: what restores the detail of textures in between, by their weights.

        center: their mean colors (C, 1), which are linear in the weights. inside (H, W): 0 where pixels tell nothing of
        an image's own detail, else 1; None: 1.
        """
        if len(weighting.palette) == 1:
            return cls((among(weighting.palette[0]),), (None,), (inside,), (None,), kept)
        knots: list[Tensor] = []
        for weights in weighting.palette:
            there = torch.tensor(weights, dtype=torch.float32)
            if all(float((there - knot).abs().amax()) >= _APART for knot in knots):
                knots.append(there)
        near = [(weighting.values - k.view(-1, 1, 1)).square().sum(0).div(-(_APART**2)).exp() for k in knots]
        total = torch.stack(near).sum(0).clamp(min=1e-12)
        counted = [share for share in (each / total for each in near) if float(_within(share, inside).sum()) >= _ENOUGH]
        rest = sum(counted, torch.zeros_like(total)).clamp(min=1e-12)
        shares = [share / rest for share in counted]
        told = [_within(share, inside) for share in shares]
        # what a region holds is not what its knot is, at the border of an image least of all: its mean is
        means = [tuple((weighting.values.double() * s).sum((1, 2)).div(s.double().sum()).tolist()) for s in told]
        ends = torch.cat([center(tuple(row)) for row in torch.eye(len(weighting.values)).double().tolist()], 1)
        due = (ends @ weighting.values.double().flatten(1)).view(-1, *weighting.shape)
        shifts = tuple((due - center(mean)[..., None]).float() for mean in means)
        return cls(tuple(among(mean) for mean in means), tuple(shares), tuple(told), shifts, kept)

    def given_to(self, image: Tensor) -> Tensor:
        """An image (C, H, W) with the detail."""
        made = torch.zeros_like(image)
        for restored, share, told, shift in zip(self.restoring, self.shares, self.told, self.shifts, strict=True):
            if share is None or shift is None:
                made = restored(image, told)
            else:
                made = made + share * (restored(image - shift, told) + shift)
        made = made if self.restoring else image
        return made if self.kept is None else torch.where(self.kept, image, made)

    def between(self, channels: int) -> Callable[[Tensor, Step], Tensor]:
        """What `kwatra.optimize` applies after each blend: to so many channels, at full resolution; others stay."""

        def given(image: Tensor, step: Step) -> Tensor:
            return image if max(step.factors) > 1 else torch.cat([self.given_to(image[:channels]), image[channels:]])

        return given


def _within(share: Tensor, inside: Tensor | None) -> Tensor:
    return share if inside is None else share * inside


def strength(image: Tensor, textures: Sequence[Tensor], weights: Weights) -> float:
    """How strong the strongest octave of an image's detail is beside that between textures (C, H, W); 1: equal.

    Three octaves of a Laplacian pyramid (Burt and Adelson, The Laplacian pyramid as a compact image code, 1983); what
    lies between the textures': see `synth.metamorphosis.recolor.barycenter`. Sizes may differ.
    """
    octaves = zip(*(_octaves(each) for each in (image, *textures)), strict=True)
    return max(
        float(own.covariance.trace() / barycenter(theirs, weights).covariance.trace()) ** 0.5
        for own, *theirs in octaves
    )


def _octaves(image: Tensor) -> list[Colors]:
    found = []
    for _ in range(3):
        low = torch.from_numpy(gaussian_filter(image.numpy(), (0, 1, 1)))
        found.append(Colors.of(image - low))
        image = low[:, ::2, ::2]
    return found


def dilated(mask: Tensor, reach: int) -> Tensor:
    """A mask (H, W), True also up to `reach` pixels away along either axis."""
    return torch.from_numpy(maximum_filter(mask.numpy(), 2 * reach + 1))
