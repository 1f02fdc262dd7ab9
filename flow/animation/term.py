"""The flow term: a frame is wanted close to the frame before it, carried along (thesis section 6.2.1).

With the texture's copies given, the frame of least energy is a weighted mean of them and of that frame, pixel by pixel;
of what has been replaced little more than a trace may last, or it is seen through what is there now.
"""

import numpy as np
import torch
import torch.nn.functional as F
from scipy import ndimage
from torch import Tensor

from flow.animation.stock import counted
from flow.warps import Lookup, filled, warp
from kwatra import SoftPixels
from kwatra.base import mean
from kwatra.cut import FREE, KEEP, TAKE, best_cut

_RIM = 0.18
"""So much of what is replaced, in a block's side, is its rim. Of made stones and radishes in a pair of vortices motion
is off by .202 px with .25, half of it the outer part, by .193 so, by .248 with .15, in all of which cuts may lie."""

_OUTER = 1 / 3
"""So much of the rim, the outer part, goes at once; where in the rest the middle begins a cut decides."""

_UNLIKE = 0.15
"""What differs by so many deviations of the exemplar counts for half of what it counts where both agree."""

_ALIKE = 3
"""Where they agree the frame before counts so many times as much as where they do not. Of these stones and radishes the
frames flicker by .080 with 1, by .075 with 4; of the sharpness of fast frames that loses .02 to .03."""


def flow_term(before: Tensor, look: Lookup, weight: float, interpolation: str = "bicubic") -> SoftPixels:
    """The flow energy weight * (x - x+)^T K (x - x+) of a frame (thesis equation 27).

    x+ is the frame before, (C, H, W), warped by `look` (interpolation: see `flow.warp`); K is the gradient weight of
    x+, 0 where nothing is known.
    """
    carried = filled(warp(before, look.coordinates, interpolation), look.known)
    shares = torch.full((len(before), 1, 1), 1 / len(before), device=before.device)
    return SoftPixels(carried, (weight * gradient_weight(carried, shares) * look.known)[None], "flow")


def lasting(off: Tensor, changed: Tensor, weight: float, block: int) -> Tensor:
    """Which share (H, W) of a frame still is the one before, carried along, where its copies were replaced (H, W).

    off (H, W): the squared difference of the two, in the exemplar's variances. The share is w / (1 + w), which makes
    |x - copies|^2 + w |x - x+|^2 least, where w is `weight` if they are unlike and _ALIKE times that if they agree: the
    flow counts robustly, as under a Lorentzian (Black and Anandan 1996), or what is replaced would be seen through what
    replaces it. In the middle of what was replaced, by a block so many px wide, it is all (see `held`).
    """
    alike = weight * (1 + (_ALIKE - 1) / (1 + off / _UNLIKE**2))
    return torch.where(held(off, changed, _RIM * block), 1.0, alike / (1 + alike))


def held(off: Tensor, changed: Tensor, rim: float) -> Tensor:
    """The middle (H, W) of what was replaced (H, W), which goes a frame later than its rim, up to so many px wide.

    So what changes at a time is small enough that what moves on around it tells the motion, and nothing is seen twice.
    Where in the rim the middle begins a minimum cut decides, along which both pictures differ least (off: as in
    `lasting`), so that elements go as a whole.
    """
    middle, apart = np.zeros(changed.shape, bool), counted(off.sqrt().numpy())
    parts, _ = ndimage.label(changed.numpy())
    for number, (rows, columns) in enumerate(ndimage.find_objects(parts), 1):
        box = slice(max(rows.start - 1, 0), rows.stop + 1), slice(max(columns.start - 1, 0), columns.stop + 1)
        part = parts[box] == number
        depth = ndimage.distance_transform_edt(part)
        if depth.max() <= rim:
            continue
        choice = np.where(depth > rim, TAKE, np.where(depth > _OUTER * rim, FREE, KEEP))
        pairs = []
        for axis in range(2):
            cost = np.delete(apart[box], -1, axis) + np.delete(apart[box], 0, axis) + 1
            pairs.append((np.zeros_like(cost), cost, cost))
        middle[box] |= best_cut(choice, pairs)
    return torch.from_numpy(middle)


def gradient_weight(image: Tensor, share: Tensor) -> Tensor:
    """K (H, W): motion is seen where colors change, so there the flow counts more (thesis 6.2.1); mean 1.

    image (C, H, W); share (C, 1, 1): how much each channel counts, sum 1.
    """
    padded = F.pad(image[None], (0, 1, 0, 1), mode="replicate")[0]
    steps = (padded[:, :-1, 1:] - image).abs() + (padded[:, 1:, :-1] - image).abs()
    slope = (steps * share).sum(0)
    return 0.5 + 0.5 * slope / mean(slope).clamp(min=1e-6)
