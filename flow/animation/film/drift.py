"""The exemplar's own motion, smooth in space and time: what its texture does on the whole, not what each drop does."""

import torch
from scipy import ndimage
from torch import Tensor

from flow.warps import BORDER, seen
from kwatra import Exemplar

_SPACE, _TIME = 8.0, 6.0
"""The motion seen is blurred by so many px and frames."""


def drift(exemplar: Exemplar) -> Tensor:
    """The motion (2, T, H, W) of an exemplar of videos, in px per frame, x first: from each frame, and in the last one.

    It is the optical flow (`flow.seen`), averaged around every place and time where there is texture; 0 in a single
    frame, and in frames too small for it to be seen.
    """
    frames, height, width = exemplar.shape
    still = torch.zeros(2, frames, height, width, dtype=torch.float32, device=exemplar.canvas.device)
    if frames < 2 or min(height, width) < BORDER:
        return still
    low, high = exemplar.canvas.amin(), exemplar.canvas.amax()
    pictures = (exemplar.canvas - low) / (high - low).clamp(min=1e-12)
    pairs = [seen(one, other) for one, other in zip(pictures.unbind(1), pictures.unbind(1)[1:], strict=False)]
    flows = torch.stack([*pairs, pairs[-1]], 1)
    known = (exemplar.owner >= 0).to(flows)
    weight = _blurred(known[None]).clamp(min=1e-6)
    return _blurred(flows * known) / weight


def _blurred(values: Tensor) -> Tensor:
    """Values (C, T, H, W) blurred over space and time."""
    width = (_TIME, _SPACE, _SPACE)
    smooth = ndimage.gaussian_filter(values.cpu().numpy(), width, mode="nearest", axes=(1, 2, 3))
    return torch.from_numpy(smooth).to(values.device)
