"""Copies of a video that were replaced fade: they live on for some frames below those that took their place.

The frame before, x+, is only as alive as what it is made of. Were its colors carried, what is replaced would fade as it
was in that frame, and what replaces it, which moves on, would leave a dark print of itself behind. So the copies below
are coordinates as well, which flow and live on with those above; what is shown is x+ where nothing is replaced, and
else a mean of x+ and the new copies, as the flow term asks for (`flow.animation.term`), of which the lowest layer of
three is left out. A mean of unrelated textures is flat, so its details get back the variance that mixing takes from
them, scale by scale (variance-preserving blending, see Heitz and Neyret 2018; here by what is found around each pixel).
What the mean of a few px is still brighter or darker by, the shade, lasts longer.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from flow.animation.carrying import blurred, carried
from flow.animation.film import Film
from flow.warps import Lookup, filled, warp
from kwatra.base import over_channels

_SHADES = 6.0
"""Shades are colors blurred by so many px."""

_SCALES = (8.0, 3.0)
"""Details are what colors differ by from so many px around, the coarsest first: those of a finer scale are a part of
those of a coarser one. Of smoke in a pair of vortices .92 of the sharpness is left by both once seams are feathered,
.89 by the finer alone; a third one of 1 px leaves .95, but lifts what is coarse, and was right, by a sixth."""


@dataclass(frozen=True)
class Fading:
    """What lies below a frame's copies.

    below (2, H, W): the source coordinates of what was replaced; share (H, W) in [0, 1): how much of it is still shown;
    shade (C, H, W): what is added to both.
    """

    below: Tensor
    share: Tensor
    shade: Tensor

    @classmethod
    def unpacked(cls, values: Tensor) -> "Fading":
        """As `packed` (2 + 1 + C, H, W)."""
        return cls(values[:2], values[2], values[3:])

    @property
    def packed(self) -> Tensor:
        """All of it as one tensor (2 + 1 + C, H, W)."""
        return torch.cat([self.below, self.share[None], self.shade])

    @classmethod
    def nothing(cls, source: Tensor, image: Tensor) -> "Fading":
        """Nothing below a frame (C, H, W) that shows source coordinates (2, H, W)."""
        return cls(source, torch.zeros_like(source[0]), torch.zeros_like(image))

    def onward(self, film: Film, look: Lookup, inside: Tensor) -> "Fading":
        """The same a frame later: carried as `look` says from where there was texture (H, W), and lived on."""
        below = film.onward(carried(self.below, look, inside))
        share = warp(self.share[None], look.coordinates, "bilinear")[0] * look.known
        shade = filled(warp(self.shade, look.coordinates, "bilinear"), look.known)
        return Fading(below, share, shade)

    def mixed(self, above: Tensor, below: Tensor) -> Tensor:
        """The mean (C, H, W) of what is above and what is below."""
        return above + self.share * (below - above)

    def shown(self, above: Tensor, below: Tensor, known: Tensor, colors: int) -> Tensor:
        """What is shown (C, H, W) where copies (C, H, W) lie above others, known (H, W) wherever they are seen.

        Details of the first so many channels, the colors, stay as strong as those of both are on average.
        """
        mean = self.mixed(above, below)
        one, other = (strengths(picture[:colors], known) for picture in (above, below))
        least = (1 - self.share).square() * one + self.share.square() * other
        return torch.cat([strengthened(mean[:colors], self.mixed(one, other), least, known), mean[colors:]])

    def replaced(self, source: Tensor, changed: Tensor, left: float) -> "Fading":
        """What lies below once copies at source coordinates (2, H, W) were replaced where they changed (H, W).

        left: how much of what was shown of it in the frame before is shown now.
        """
        below = torch.where(changed, source, self.below)
        return Fading(below, left * torch.where(changed, 1.0, self.share), self.shade)


def strengths(colors: Tensor, known: Tensor) -> Tensor:
    """How strong details of colors (C, H, W) are around each pixel, where they are known (H, W), at each scale.

    That is their mean square, (len(_SCALES), H, W).
    """
    return torch.cat([_strength(_detail(colors, known, scale), known, scale) for scale in _SCALES])


def strengthened(mean: Tensor, wanted: Tensor, least: Tensor, known: Tensor) -> Tensor:
    """A mean (C, H, W) of pictures, known (H, W), its details brought to the strengths wanted (len(_SCALES), H, W).

    least: those that the mean has if the pictures are unrelated, each strength times the square of its share; below
    these details are weak for another reason, which is not made up for. None becomes weaker.
    """
    for scale, strength, low in zip(_SCALES, wanted, least, strict=True):
        detail = _detail(mean, known, scale)
        now = _strength(detail, known, scale)[0].maximum(low)
        gain = (strength.clamp(min=1e-12) / now.clamp(min=1e-12)).clamp(min=1).sqrt()
        mean = mean + (gain - 1) * detail
    return mean


def _detail(colors: Tensor, known: Tensor, scale: float) -> Tensor:
    """What colors (C, H, W) differ by from those around, where they are known (H, W)."""
    return colors - blurred(colors, known, scale)


def _strength(detail: Tensor, known: Tensor, scale: float) -> Tensor:
    """The mean square (1, H, W) of details (C, H, W) around each pixel."""
    return blurred(over_channels(detail.square())[None], known, scale)


def left_of(film: Film, frames: float) -> float:
    """How much of what was replaced is left from frame to frame: after so many of them, >= 0, as much as the film
    itself keeps after one. So texture that changes fast does not blur, and in what changes slowly nothing jumps.
    """
    return 0.0 if frames == 0 else film.memory ** (1 / frames)


def shaded(before: Tensor, after: Tensor, known: Tensor, shades: float) -> Tensor:
    """The shade (C, H, W) of a frame `after` where the one before (C, H, W) is known (H, W)."""
    if shades == 0:
        return torch.zeros_like(after)
    return torch.where(known, shades * blurred(torch.where(known, before - after, 0.0), known, _SHADES), 0.0)
