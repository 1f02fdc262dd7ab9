"""The flow term: a frame is wanted close to the frame before it, carried along (thesis section 6.2.1).

With the texture's copies given, the frame of least energy is a weighted mean of them and of that frame, pixel by pixel.
"""

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import Lookup, filled, warp
from kwatra import SoftPixels
from kwatra.base import mean


def flow_term(before: Tensor, look: Lookup, weight: float, interpolation: str = "bicubic") -> SoftPixels:
    """The flow energy weight * (x - x+)^T K (x - x+) of a frame (thesis equation 27).

    x+ is the frame before, (C, H, W), warped by `look` (interpolation: see `flow.warp`); K is the gradient weight of
    x+, 0 where nothing is known.
    """
    carried = filled(warp(before, look.coordinates, interpolation), look.known)
    shares = torch.full((len(before), 1, 1), 1 / len(before), device=before.device)
    return SoftPixels(carried, (weight * gradient_weight(carried, shares) * look.known)[None], "flow")


def blended(copies: Tensor, term: SoftPixels) -> Tensor:
    """The frame x (C, H, W) of least |x - copies|^2 + weight |x - target|^2, for a term with a weight per pixel.

    Where the term has no weight, or copies (C, H, W) are what it asks for, they are returned bit for bit.
    """
    return copies + term.weight / (1 + term.weight) * (term.target - copies)


def gradient_weight(image: Tensor, share: Tensor) -> Tensor:
    """K (H, W): motion is seen where colors change, so there the flow counts more (thesis 6.2.1); mean 1.

    image (C, H, W); share (C, 1, 1): how much each channel counts, sum 1.
    """
    padded = F.pad(image[None], (0, 1, 0, 1), mode="replicate")[0]
    steps = (padded[:, :-1, 1:] - image).abs() + (padded[:, 1:, :-1] - image).abs()
    slope = (steps * share).sum(0)
    return 0.5 + 0.5 * slope / mean(slope).clamp(min=1e-6)
