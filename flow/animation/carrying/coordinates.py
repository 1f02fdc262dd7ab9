"""Texture carried along a flow as source coordinates, not as colors.

A frame is kept as the place in the exemplar that each of its pixels shows, (2, H, W), x first, in fractions of a
pixel. Carried along, coordinates lose nothing that matters: every frame reads the exemplar once, so the thousandth is
as sharp as the first. Where two copies of the exemplar meet, coordinates jump; there they are not interpolated.
"""

import torch
from torch import Tensor

from flow.animation.carrying.copies import JUMP, angle_of, onward, turned
from flow.warps import Lookup, filled, pixel_coordinates


def carried(source: Tensor, look: Lookup, inside: Tensor | None = None) -> Tensor:
    """The source coordinates (2, H, W) of the next frame, where `look` says what flows to each pixel.

    inside (H, W): where the frame before has texture; what its coordinates are elsewhere has no influence.
    What flows in from elsewhere continues the nearest copy that is there: its coordinates may lie outside the
    exemplar. If nothing is known, the coordinates stay as they are. Zero flow and whole-pixel shifts are exact.
    """
    if not bool(look.known.any()):
        return source
    from flow.animation.carrying.loops import carry

    there = torch.ones_like(source[0], dtype=torch.bool) if inside is None else inside
    beside = turned(source, inside)
    after, first = torch.empty(source.shape, dtype=torch.float32), torch.empty(source[0].numel(), dtype=torch.long)
    before = (values.contiguous() for values in (source, there, beside))
    carry(len(first), *before, look.coordinates.flatten(1), JUMP, after.flatten(1), first)
    if bool(look.known.all()):
        return after
    pixels = pixel_coordinates(source.shape[1:])
    beyond = ~look.known
    (column, row), (x, y) = filled(pixels, look.known)[:, beyond].long(), pixels[:, beyond]
    angle = angle_of(beside.flatten(1)[:, first.view(there.shape)[row, column]])
    after[:, beyond] = onward(after[:, row, column], angle, y - row, x - column)
    return after
