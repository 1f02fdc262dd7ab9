"""Seams drawn over the picture."""

from __future__ import annotations

import torch
from torch import Tensor

from synth.quilting.synthesis import Quilt

RED = (1.0, 0.1, 0.1)


def seams_drawn(quilt: Quilt) -> Tensor:
    """The picture or video in RGB, (3, *S), with the pixels on either side of a border between patches in red.

    Seams that cost nothing are left out: there the patches agree and nothing can be seen. Values are clipped to [0, 1].
    """
    on = torch.zeros(quilt.patch.shape, dtype=torch.bool)
    for axis, cost in enumerate(quilt.seams):
        on |= cost > 0
        on |= (cost > 0).roll(1, axis)
    channels = quilt.image.shape[0]
    image = quilt.image[:3] if channels >= 3 else quilt.image[:1].expand(3, *quilt.patch.shape)
    red = torch.tensor(RED, dtype=torch.float32).reshape(3, *[1] * on.ndim)
    return torch.where(on, red, image.clamp(0, 1))
