"""Where a texture has features, found without help: its edges, or its blobs, as maps (1, H, W) of about one scale."""

from collections.abc import Callable

import numpy as np
import torch
from scipy.ndimage import gaussian_filter, gaussian_gradient_magnitude
from torch import Tensor


def edges(image: Tensor) -> Tensor:
    """How much the brightness of an image (C, H, W) changes at each pixel, seen with a blur of 1 px."""
    return _filtered(image, lambda gray: gaussian_gradient_magnitude(gray, 1.0))


def blobs(image: Tensor) -> Tensor:
    """How much brighter or darker (C, H, W) is, in 4 px around, than its surroundings in 12 px: elements, or gaps."""
    return _filtered(image, lambda gray: abs(gaussian_filter(gray, 1.5) - gaussian_filter(gray, 4.5)))


def _filtered(image: Tensor, apply: Callable[[np.ndarray], np.ndarray]) -> Tensor:
    gray = image.mean(0).cpu().numpy()
    return torch.from_numpy(apply(gray))[None].to(image)


FOUND: dict[str, Callable[[Tensor], Tensor]] = {"none": lambda image: image[:0], "edges": edges, "blobs": blobs}
"""What can be looked for, by name."""
