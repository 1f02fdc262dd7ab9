"""Pictures blurred where they are known."""

import torch
from scipy import ndimage
from torch import Tensor


def blurred(image: Tensor, known: Tensor, width: float) -> Tensor:
    """An image (C, H, W) blurred over its known pixels (H, W) by a Gaussian of `width` px."""

    def blur(values: Tensor) -> Tensor:
        smooth = ndimage.gaussian_filter(values.cpu().numpy(), width, mode="nearest", axes=(1, 2))
        return torch.from_numpy(smooth).to(values.device)

    if bool(known.all()):
        return blur(image)
    return blur(image * known) / blur(known[None].float()).clamp(min=1e-6)
