"""Colors and alpha: what is mixed is color times alpha, so that colors that cannot be seen color nothing."""

import torch
from torch import Tensor

from synth.io.images import from_pixels, to_pixels
from synth.io.kinds import Array, Kind

UNSEEN = 1e-6
"""Alpha of which no color can be told: a fifteenth of the least that 16 bits hold. Frames of flows hold as little as
3e-45 where there is none, of which 1 / alpha is infinite."""


def mixed(array: Array, kind: Kind) -> Array:
    """Values (H, W, C) as a file holds them, made fit to be mixed; as they are where there is no alpha to heed."""
    if not _straight(kind):
        return array
    return premultiplied(to_pixels(array), kind).permute(1, 2, 0).numpy()


def unmixed(array: Array, kind: Kind) -> Array:
    """The inverse of `mixed`, up to rounding."""
    if not _straight(kind):
        return array
    return from_pixels(straight(torch.from_numpy(array).permute(2, 0, 1), kind), kind)


def premultiplied(pixels: Tensor, kind: Kind) -> Tensor:
    """Pixels (C, *S) of this kind with their colors multiplied by alpha, unless they are so already."""
    if not _straight(kind):
        return pixels
    return _colors_times(pixels, pixels[kind.channels.index("A")], kind)


def straight(pixels: Tensor, kind: Kind) -> Tensor:
    """The inverse of `premultiplied`; where alpha is UNSEEN or less colors are 0."""
    if not _straight(kind):
        return pixels
    alpha = pixels[kind.channels.index("A")]
    return _colors_times(pixels, torch.where(alpha > UNSEEN, 1 / alpha, 0.0), kind)


def _straight(kind: Kind) -> bool:
    return "A" in kind.channels and not kind.premultiplied


def _colors_times(pixels: Tensor, factor: Tensor, kind: Kind) -> Tensor:
    colors = torch.tensor([name in ("Y", "R", "G", "B") for name in kind.channels])
    return torch.where(colors.view(-1, *[1] * (pixels.ndim - 1)), pixels * factor, pixels)
