"""How strong each scale of a texture is, and making an image as strong: what averages and blends take away, given back.

An image is split into bands of detail by blurs of 1, 2 and 4 px; a band's values, like colors, are taken for a Gaussian
of as many dimensions as the image has channels (see `recolor`). Between two textures a band's Gaussian is on its way
by optimal transport. Texture synthesis by matching what bands hold is due to Heeger and Bergen, Pyramid-based texture
analysis/synthesis, 1995.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from kwatra import Step
from synth.metamorphosis.method import Pair
from synth.metamorphosis.recolor import Colors, barycenter, recolored

_BLURS = (1.0, 2.0, 4.0)
"""Standard deviations, in px, of the blurs that part one band after the other, an octave each: not tuned."""


@dataclass(frozen=True)
class Bands:
    """What the bands of an image hold, fine to coarse, the blurred rest last; `Bands.of` an image."""

    colors: tuple[Colors, ...]
    wrap: bool

    @classmethod
    def of(cls, image: Tensor, wrap: bool = False) -> "Bands":
        """Those of an image (C, H, W); wrap: it is periodic."""
        return cls(tuple(Colors.of(band) for band in _split(image, wrap)), wrap)

    @classmethod
    def among(cls, bands: "Sequence[Bands]", weights: Sequence[float]) -> "Bands":
        """Those between several textures, by their weights, which sum to 1."""
        layers = zip(*(each.colors for each in bands), strict=True)
        return cls(tuple(barycenter(layer, weights) for layer in layers), bands[0].wrap)

    def given_to(self, image: Tensor) -> Tensor:
        """An image (C, H, W) with these bands: the same picture, its details as strong."""
        bands = zip(_split(image, self.wrap), self.colors, strict=True)
        return torch.stack([recolored(band, Colors.of(band), goal) for band, goal in bands]).sum(0)

    def within(self, own: "Bands", gain: float) -> "Bands":
        """These, of at most `gain` times the amplitude of an image's own, and of less where still more is missing.

        A band that has to become g times as strong becomes gain^2 / g times as strong beyond `gain`, or stays.
        """
        colors = []
        for have, want in zip(own.colors, self.colors, strict=True):
            lost = max(float(want.covariance.trace() / have.covariance.trace().clamp(min=1e-30)), 1.0)  # g^2
            share = max(min(1.0, gain**4 / lost**2), 1 / lost)
            colors.append(replace(want, covariance=share * want.covariance))
        return replace(self, colors=tuple(colors))

    def between(self, image: Tensor, step: Step) -> Tensor:
        """What `kwatra.optimize` applies after each blend, at full resolution."""
        return self.given_to(image)


_STRONGEST = 2.0
"""Halfway, details that have nothing to do with each other are 1.4 times weaker; warps take some of the rest."""

SETTLING = 3
"""So often a finished image is given what it is to have: bands overlap, and once leaves a fifth of the finest missing;
a step towards statistics goes only a part of the way. Fast stills between six pairs of photographs are as sharp
with 4, within .001; with 2, up to .008 less."""


def settled(image: Tensor, given_to: Callable[[Tensor], Tensor]) -> Tensor:
    """A finished image (C, H, W) that has been given what it is to have as often as that takes, in [0, 1]."""
    for _ in range(SETTLING):
        image = given_to(image).clamp(0, 1)
    return image


def bands_at(pair: Pair, time: float) -> Bands:
    """The bands of a texture on its way from A to B."""
    return Bands.among([Bands.of(image, pair.tile) for image in (pair.a, pair.b)], (1 - time, time))


def dissolved(a: Tensor, b: Tensor, part: float, pair: Pair) -> Tensor:
    """The mixture (C, H, W) of two frames, `part` of it b, with the bands of the pair's texture at that time.

    Those of the frames themselves are not as good: what moved or made them changed how much of each color they have.
    Nothing is strengthened more than _STRONGEST times, and what would need far more is left: where dark meets light
    both cancel, and the rest is noise.
    """
    if part in (0, 1):
        return b if part else a
    mixed = torch.lerp(a, b, part)
    goal = bands_at(pair, part).within(Bands.of(mixed, pair.tile), _STRONGEST)
    return settled(mixed, goal.given_to)


def _split(image: Tensor, wrap: bool) -> list[Tensor]:
    """Bands that sum to the image."""
    bands, rest = [], image
    for blur in _BLURS:
        low = gaussian_filter(rest.cpu().numpy(), (0, blur, blur), mode="wrap" if wrap else "reflect")
        bands.append(rest - torch.from_numpy(low).to(rest))
        rest = torch.from_numpy(low).to(image)
    return [*bands, rest]
