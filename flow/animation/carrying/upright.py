"""Copies turned upright: elements of the texture keep their size and orientation while they flow (thesis 6.2).

A flow carries, and also turns and stretches. Of every carried copy the part that is not rigid is undone a little in
every frame, so that nothing has to be replaced because it was turned: source coordinates S + u instead of S, where u
minimizes

    sum_p d(p) |u(p)|^2 + stiffness * sum_pq d(p, q)^2 |u(q) - u(p) + c(p, q)|^2 .

d is the exemplar's detail, its gradients' energy, where S reads it: the motion of what is flat is not seen (which is
the gradient weight K of thesis equation 27, for small motions), nor is its distortion. c is what the offset of S
changes by between neighbors of one copy, shortened where that is much, and 0 across a seam: elements are stiff, the
flat gaps between them give way, and the two sides of a seam stay together.

Where the exemplar prefers no direction there is none to keep: c is then what S changes by more than in a copy that is
turned as this one is on the whole, around each pixel. Elements turn with the flow, and only their bending is undone.
"""

from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from flow.animation.carrying.blur import blurred
from flow.animation.carrying.copies import JUMP, angles, rigid
from flow.warps import warp
from kwatra import Exemplar
from kwatra.base import atan2, continued, mean, over_channels

Array = np.ndarray[Any, Any]

_AROUND = 1.5
"""Detail is blurred by so many px: what is beside an edge belongs to it. Tried: .206 with half, .209 with
twice as much."""

_FLAT = 0.02
"""The least detail, in multiples of its mean."""

_MOST = 0.12
"""The largest change of the offset from pixel to pixel that is undone in one frame: a flow that turns its texture
faster than that would be halted. Tried: .227 with half, .207 with twice as much."""

_TOLERANCE, _STEPS = 0.05, 15
"""When the minimum is near enough: what is left over is undone in the next frame."""

_FIXED = 1e6
"""The weight d of pixels that are to stay where they are."""


class Upright:
    """Turns copies of an exemplar upright, as far as `stiffness` >= 0 (in px^2) asks for; 0: not at all.

    turning > 0: copies may turn, as one over so many px, and are made rigid only.
    """

    def __init__(self, exemplar: Exemplar, stiffness: float, turning: float = 0.0) -> None:
        self.stiffness, self._turning = stiffness, turning
        canvas = continued(exemplar.canvas, exemplar.owner)
        padded = F.pad(canvas[None], (0, 1, 0, 1), mode="replicate")[0]
        slopes = padded[:, :-1, 1:] - canvas, padded[:, 1:, :-1] - canvas
        energy = over_channels((slopes[0].square() + slopes[1].square()) * exemplar.share)
        smooth = blurred(energy[None], torch.ones_like(energy, dtype=torch.bool), _AROUND)[0]
        self._detail = (smooth / mean(smooth).clamp(min=1e-12)).clamp(min=_FLAT)

    def __call__(self, source: Tensor, free: Tensor) -> Tensor:
        """Source coordinates (2, H, W) made more upright where free (H, W); elsewhere they are left alone.

        A frame of rigid copies is returned bit for bit.
        """
        if self.stiffness == 0 or not bool(free.any()):
            return source
        detail = warp(self._detail[None], source, "bilinear")[0]
        _, beside = rigid(self._turned(source, free))
        frame = (values.contiguous().numpy() for values in (source, detail, free, beside))
        return source + free * torch.from_numpy(self._offset(*frame))

    def _offset(self, source: Array, detail: Array, free: Array, beside: Array) -> Array:
        """u (2, H, W) of a frame; beside (2, H, W): what its copies change by to the right where they may stay."""
        from flow.animation.carrying.stiffness import bends, solve, ties

        anchor = np.pad(np.where(free, detail, np.float32(_FIXED)), 1, constant_values=1)
        tall, wide, pull, offset = (np.zeros((*more, *anchor.shape), np.float32) for more in ((), (), (2,), (2,)))
        for axis, tied in enumerate((tall, wide)):
            ties(detail, free, np.float32(self.stiffness), axis, tied)
            bends(source, beside, axis, np.float32(JUMP), np.float32(_MOST), tied, pull)
        solve(anchor, tall, wide, pull, _TOLERANCE, _STEPS, offset)
        return offset[:, 1:-1, 1:-1]

    def _turned(self, source: Tensor, free: Tensor) -> Tensor:
        """The angle (H, W) by which copies are turned and may stay so: that around each pixel, or 0."""
        if self._turning == 0:
            return torch.zeros_like(source[0])
        angle = angles(source, free)
        sin, cos = blurred(torch.stack([angle.sin(), angle.cos()]), torch.ones_like(free), self._turning)
        return atan2(sin, cos)
