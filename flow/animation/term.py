"""The flow term: a frame is wanted close to the frame before it, carried along (thesis section 6.2.1).

With the texture's copies given, the frame of least energy is a weighted mean of them and of that frame, pixel by pixel.
Only where both are alike does that frame count: what is replaced is never seen through what replaces it.
"""

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import Lookup, filled, warp
from kwatra import SoftPixels
from kwatra.base import mean, over_channels

_UNLIKE = 0.3
"""What differs by so many deviations of the exemplar counts for 1 / e of what it counts where both agree. Of made
stones, radishes, nuts and bricks in a pair of vortices frames flicker by .089 with half of it and half of the weight,
.082 with this, .078 with .5, with which what is replaced begins to be seen. Motion is off by .254 px; by .189 were what
is replaced seen for a frame, a third of it, through what replaces it; by .207 if it went over in parts, element by
element or within edges, over four frames, in which stones fray and lines end loosely."""


def flow_term(before: Tensor, look: Lookup, weight: float) -> SoftPixels:
    """The flow energy weight * (x - x+)^T K (x - x+) of a frame (thesis equation 27).

    x+ is the frame before, (C, H, W), warped by `look`; K is the gradient weight of x+, 0 where nothing is known.
    """
    carried = filled(warp(before, look.coordinates), look.known)
    shares = torch.full((len(before), 1, 1), 1 / len(before), dtype=torch.float32, device=before.device)
    return SoftPixels(carried, (weight * gradient_weight(carried, shares) * look.known)[None], "flow")


def lasting(off: Tensor, weight: float) -> Tensor:
    """Which share (H, W) of a frame still is the one before, carried along.

    off (H, W): the squared difference of its copies and that frame, in the exemplar's variances. The share is
    w / (1 + w), which makes |x - copies|^2 + w |x - x+|^2 least, where w is `weight` if they agree and goes to 0 as a
    Gaussian of what they differ by: the flow counts robustly (as under Welsch's function), and where two elements lie
    at one place only one is seen. With a weight of 1.5 no pixel is off its copies by more than .11 deviations.
    """
    counts = weight * torch.exp(-off / _UNLIKE**2)
    return counts / (1 + counts)


def gradient_weight(image: Tensor, share: Tensor) -> Tensor:
    """K (H, W): motion is seen where colors change, so there the flow counts more (thesis 6.2.1); mean 1.

    image (C, H, W); share (C, 1, 1): how much each channel counts, sum 1.
    """
    padded = F.pad(image[None], (0, 1, 0, 1), mode="replicate")[0]
    steps = (padded[:, :-1, 1:] - image).abs() + (padded[:, 1:, :-1] - image).abs()
    slope = over_channels(steps * share)
    return 0.5 + 0.5 * slope / mean(slope).clamp(min=1e-6)
