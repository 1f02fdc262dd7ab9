"""Texture carried along a flow as source coordinates, not as colors.

A frame is kept as the place in the exemplar that each of its pixels shows, (2, H, W), x first, in fractions of a
pixel. Carried along, coordinates lose nothing that matters: every frame reads the exemplar once, so the thousandth is
as sharp as the first. Where two copies of the exemplar meet, coordinates jump; there they are not interpolated.
"""

import torch
from torch import Tensor

from flow.animation.copies import JUMP
from flow.warps import Lookup, filled, pixel_coordinates


def carried(source: Tensor, look: Lookup, inside: Tensor | None = None) -> Tensor:
    """The source coordinates (2, H, W) of the next frame, where `look` says what flows to each pixel.

    inside (H, W): where the frame before has texture; what its coordinates are elsewhere has no influence.
    What flows in from elsewhere continues the nearest copy that is there: its coordinates may lie outside the
    exemplar. If nothing is known, the coordinates stay as they are. Zero flow and whole-pixel shifts are exact.
    """
    if not bool(look.known.any()):
        return source
    height, width = source.shape[1:]
    pixels = pixel_coordinates(source.shape[1:], source.device)
    here, offset = source.flatten(1), (source - pixels).flatten(1)
    x, y = look.coordinates[0].clamp(0, width - 1).flatten(), look.coordinates[1].clamp(0, height - 1).flatten()
    left, top = x.floor().clamp(max=max(width - 2, 0)), y.floor().clamp(max=max(height - 2, 0))
    across, down = x - left, y - top
    middle = (y.round() * width + x.round()).long()
    nearest = offset[:, middle]
    first = (top * width + left).long()
    change, mass = torch.zeros_like(nearest), torch.zeros_like(x)
    for step, share in (
        (0, (1 - across) * (1 - down)),
        (1, across * (1 - down)),
        (width, (1 - across) * down),
        (width + 1, across * down),
    ):
        corner = (first + step).clamp(max=height * width - 1)
        differs = offset[:, corner] - nearest
        counts = differs.square().sum(0) < JUMP**2
        if inside is not None:
            counts = counts & inside.flatten()[corner]
        share = share * counts
        change, mass = change + torch.where(counts, share * differs, 0.0), mass + share
    change = torch.where(mass > 0, change / mass.clamp(min=1e-12), 0.0)
    moved = here[:, middle] + (look.coordinates.flatten(1) - pixels.flatten(1)[:, middle]) + change
    moved = moved.view_as(source)
    return torch.where(look.known, moved, pixels + filled(moved - pixels, look.known))
