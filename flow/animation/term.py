"""The flow term: a frame is wanted close to the frame before it, carried along (thesis section 6.2.1).

With the texture's copies given, the frame of least energy is a weighted mean of them and of that frame, pixel by pixel;
of what has been replaced little more than a trace may last, or it is seen through what is there now.
"""

import torch
import torch.nn.functional as F
from scipy.ndimage import distance_transform_edt
from torch import Tensor

from flow.warps import Lookup, filled, warp
from kwatra import SoftPixels
from kwatra.base import mean

_RIM = 1 / 4
"""So much of what is replaced, in a block's side, is its rim. Motion of made stones in a pair of vortices is off by
.25 px with half as much, but splinters of stones are seen; by .29 so, and by .32 where all goes at once."""


def flow_term(before: Tensor, look: Lookup, weight: float, interpolation: str = "bicubic") -> SoftPixels:
    """The flow energy weight * (x - x+)^T K (x - x+) of a frame (thesis equation 27).

    x+ is the frame before, (C, H, W), warped by `look` (interpolation: see `flow.warp`); K is the gradient weight of
    x+, 0 where nothing is known.
    """
    carried = filled(warp(before, look.coordinates, interpolation), look.known)
    shares = torch.full((len(before), 1, 1), 1 / len(before), device=before.device)
    return SoftPixels(carried, (weight * gradient_weight(carried, shares) * look.known)[None], "flow")


def lasting(changed: Tensor, weight: float, block: int) -> Tensor:
    """Which share (H, W) of a frame still is the one before, carried along, where its copies were replaced (H, W).

    It is weight / (1 + weight), which makes |x - copies|^2 + weight |x - x+|^2 least: with K, edges of what is replaced
    would be seen longest, through what replaces it. In the middle of what was replaced, by a block so many px wide, it
    is all: that goes a frame later, so that what moves on around it tells the motion, and nothing is seen twice.
    """
    depth = torch.from_numpy(distance_transform_edt(changed.numpy())).float()
    return (depth - _RIM * block).clamp(weight / (1 + weight), 1)


def gradient_weight(image: Tensor, share: Tensor) -> Tensor:
    """K (H, W): motion is seen where colors change, so there the flow counts more (thesis 6.2.1); mean 1.

    image (C, H, W); share (C, 1, 1): how much each channel counts, sum 1.
    """
    padded = F.pad(image[None], (0, 1, 0, 1), mode="replicate")[0]
    steps = (padded[:, :-1, 1:] - image).abs() + (padded[:, 1:, :-1] - image).abs()
    slope = (steps * share).sum(0)
    return 0.5 + 0.5 * slope / mean(slope).clamp(min=1e-6)
