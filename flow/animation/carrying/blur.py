"""Pictures blurred where they are known."""

import torch
from torch import Tensor

_TRUNCATED = 4
"""The Gaussian ends at so many deviations: less than 1e-4 of it lies beyond."""


def blurred(image: Tensor, known: Tensor, width: float) -> Tensor:
    """An image (C, H, W) blurred over its known pixels (H, W) by a Gaussian of `width` px."""
    if bool(known.all()):
        return _blurred(image, width)
    return _blurred(image * known, width) / _blurred(known[None].float(), width).clamp(min=1e-6)


def _blurred(image: Tensor, width: float) -> Tensor:
    """An image (C, H, W) blurred; beyond its border is the border."""
    from flow.animation.carrying.loops import blur

    reach = int(_TRUNCATED * width + 0.5)
    bell = torch.exp(-0.5 * (torch.arange(-reach, reach + 1, dtype=torch.float64) / width).square())
    smooth = torch.empty(image.shape, dtype=torch.float32)
    values = image.cpu().float().contiguous()
    blur(len(image) * image.shape[1], values, (bell / bell.sum()).float(), smooth)
    return smooth.to(image)
