"""Copies of a video that were replaced fade: they live on for some frames below those that took their place.

The frame before, x+, is only as alive as what it is made of. Were its colors carried, what is replaced would fade as it
was in that frame, and what replaces it, which moves on, would leave a dark print of itself behind. So the copies below
are coordinates as well, which flow and live on with those above; what is shown is x+ where nothing is replaced, and
else a mean of x+ and the new copies, as the flow term asks for (`flow.animation.term`), of which the lowest layer of
three is left out. A mean of unrelated textures is flat, so its details get back the variance that mixing takes from
them (variance-preserving blending, see Heitz and Neyret 2018; here by what neighbors have in common). What the
mean of a few px is still brighter or darker by, the shade, lasts longer.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from flow.animation.blur import blurred
from flow.animation.carrying import carried
from flow.animation.film import Film
from flow.warps import Lookup, filled, warp

_SHADES = 6.0
"""Shades are colors blurred by so many px."""

_DETAIL = 3.0
"""Details are what colors differ by from so many px around; with 2 or 6 a plume of smoke is as sharp within .02."""


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

    def mixed(self, above: Tensor, below: Tensor, known: Tensor, colors: int) -> Tensor:
        """What is shown (C, H, W) where copies (C, H, W) lie above others: see `mixed`."""
        return mixed(above, below, self.share, known, colors)

    def replaced(self, source: Tensor, changed: Tensor, left: float) -> "Fading":
        """What lies below once copies at source coordinates (2, H, W) were replaced where they changed (H, W).

        left: how much of what was shown of it in the frame before is shown now.
        """
        below = torch.where(changed, source, self.below)
        return Fading(below, left * torch.where(changed, 1.0, self.share), self.shade)


def mixed(above: Tensor, below: Tensor, share: Tensor, known: Tensor, colors: int) -> Tensor:
    """Pictures (C, H, W) mixed: a share (H, W) is that of the one below, which is known (H, W) wherever it is seen.

    Details of the first so many channels, the colors, stay as strong as those of both are on average.
    """
    shown = above + share * (below - above)
    one, other, both = (_detail(picture[:colors], known) for picture in (above, below, shown))
    shown[:colors] += (_gain(one, other, share, known) - 1) * both
    return shown


def _detail(colors: Tensor, known: Tensor) -> Tensor:
    """What colors (C, H, W) differ by from those around, where they are known (H, W)."""
    return colors - blurred(colors, known, _DETAIL)


def _gain(one: Tensor, other: Tensor, share: Tensor, known: Tensor) -> Tensor:
    """How many times stronger (H, W) details (C, H, W) have to be in which a share is the other's.

    It is 1 for details that agree and, at equal shares, the square root of 2 for unrelated ones: at most that.
    """
    pairs = (one, one), (other, other), (one, other)
    first, second, both = blurred(torch.stack([(a * b).sum(0) for a, b in pairs]), known, _DETAIL)
    wanted = first + share * (second - first)
    mixed = (1 - share) ** 2 * first + share**2 * second + 2 * share * (1 - share) * both
    return (wanted.clamp(min=1e-12) / mixed.clamp(min=1e-12)).clamp(1, 2).sqrt()


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
