"""Texture carried along a flow as source coordinates, not as colors.

A frame is kept as the place in the exemplar that each of its pixels shows, (2, H, W), x first, in fractions of a
pixel. Carried along, coordinates lose nothing that matters: every frame reads the exemplar once, so the thousandth is
as sharp as the first. Where two copies of the exemplar meet, coordinates jump; there they are not interpolated.
"""

import torch
from torch import Tensor

from flow.animation.copies import JUMP, angles, onward
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
    here = source.flatten(1)
    x, y = look.coordinates[0].clamp(0, width - 1).flatten(), look.coordinates[1].clamp(0, height - 1).flatten()
    left, top = x.floor().clamp(max=max(width - 2, 0)), y.floor().clamp(max=max(height - 2, 0))
    across, down = x - left, y - top
    middle = (y.round() * width + x.round()).long()
    nearest, angle = here[:, middle], angles(source, inside).flatten()[middle]
    first = (top * width + left).long()
    change, mass = torch.zeros_like(nearest), torch.zeros_like(x)
    for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
        corner = (first + row * width + column).clamp(max=height * width - 1)
        differs = onward(here[:, corner] - nearest, angle, y.round() - (top + row), x.round() - (left + column))
        counts = differs.square().sum(0) < JUMP**2
        if inside is not None:
            counts = counts & inside.flatten()[corner]
        share = (down if row else 1 - down) * (across if column else 1 - across) * counts
        change, mass = change + torch.where(counts, share * differs, 0.0), mass + share
    change = torch.where(mass > 0, change / mass.clamp(min=1e-12), 0.0)
    over, under = look.coordinates.flatten(1) - pixels.flatten(1)[:, middle]
    moved = (onward(nearest, angle, under, over) + change).view_as(source)
    if bool(look.known.all()):
        return moved
    column, row = filled(pixels, look.known).long()
    end, turn = moved[:, row, column], angle.view_as(moved[0])[row, column]
    beyond = onward(end, turn, pixels[1] - row, pixels[0] - column)
    return torch.where(look.known, moved, beyond)
