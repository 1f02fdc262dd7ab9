"""What is done to the colors of a video with alpha is done so far as they are seen, and nothing to alpha.

Corrected like a color, alpha of 0 and 1 became what is half seen: what steps of it lacked was spread over all around.
"""

import torch
from torch import Tensor

from kwatra import Exemplar


def as_far_as_seen(before: Tensor, after: Tensor, exemplar: Exemplar) -> Tensor:
    """What (C, *S) something made of a still or video, but with the alpha it had before, and colors changed in
    proportion to that, and no larger. It is as it came to be where the exemplar's last channel is no alpha.
    """
    if exemplar.alpha is None:
        return after
    alpha = before[-1:]
    colors = torch.lerp(before[:-1], after[:-1], alpha.clamp(0, 1))
    return torch.cat([torch.minimum(colors, alpha), alpha])
