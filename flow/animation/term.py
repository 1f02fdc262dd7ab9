"""The flow term: a frame is wanted close to the frame before it, carried along (thesis section 6.2.1).

With the texture's copies given, the frame of least energy is a weighted mean of them and of that frame, pixel by pixel;
what is replaced passes over into what replaces it: in one frame a third of it is seen, and then a trace.
"""

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import Lookup, filled, warp
from kwatra import SoftPixels
from kwatra.base import mean

_AT_FIRST = 0.5
"""So much the frame before counts at least where copies were replaced just now, beside 1 for them. Of colored stones,
radishes and nuts in a pair of vortices motion is off by .203 px and frames flicker by .0680 so, .191 and .0675 with
.67, .181 and .0670 with 1, with which stills show what is replaced as much as what replaces it. Of these, coins and
other stones it is .225 and .0746 without, .184 and .0725 with 1; over one more frame .177 and .071, but then twice as
much is seen twice."""

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


def lasting(off: Tensor, changed: Tensor, weight: float) -> Tensor:
    """Which share (H, W) of a frame still is the one before, carried along, where its copies were replaced (H, W).

    off (H, W): the squared difference of the two, in the exemplar's variances. The share is w / (1 + w), which makes
    |x - copies|^2 + w |x - x+|^2 least, where w is `weight` if they are unlike and _ALIKE times that if they agree: the
    flow counts robustly, as under a Lorentzian (Black and Anandan 1996), or what is replaced would be seen for long
    through what replaces it. In the frame in which it is replaced w is _AT_FIRST at least.
    """
    counts = weight * (1 + (_ALIKE - 1) / (1 + off / _UNLIKE**2))
    counts = torch.where(changed, counts.clamp(min=_AT_FIRST), counts)
    return counts / (1 + counts)


def gradient_weight(image: Tensor, share: Tensor) -> Tensor:
    """K (H, W): motion is seen where colors change, so there the flow counts more (thesis 6.2.1); mean 1.

    image (C, H, W); share (C, 1, 1): how much each channel counts, sum 1.
    """
    padded = F.pad(image[None], (0, 1, 0, 1), mode="replicate")[0]
    steps = (padded[:, :-1, 1:] - image).abs() + (padded[:, 1:, :-1] - image).abs()
    slope = (steps * share).sum(0)
    return 0.5 + 0.5 * slope / mean(slope).clamp(min=1e-6)
