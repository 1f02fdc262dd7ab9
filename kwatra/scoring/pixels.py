"""What pixels by themselves say of images (C, H, W) and videos (C, T, H, W): spread, gradient, change."""

from collections.abc import Iterable, Sequence

import torch
from torch import Tensor


def deviation(images: Sequence[Tensor]) -> float:
    """Standard deviation of the pixels about their mean color, 0 when it is only rounding."""
    pixels = torch.cat([image.flatten(1) for image in images], 1).double()
    found = float(pixels.var(1, correction=0).mean().sqrt())
    return found if found > 1e-6 * float(pixels.abs().max()) else 0.0


def unit(images: Sequence[Tensor]) -> float:
    """What distances are divided by; 1, so that they stay as they are, for images of one color."""
    return deviation(images) or 1.0


def gradient(images: Iterable[Tensor]) -> float:
    """Mean absolute step down and across."""
    return _mean(image.diff(dim=axis) for image in images for axis in (-2, -1))


def change(videos: Iterable[Tensor], order: int = 1) -> float:
    """Mean absolute difference of `order` 1 or 2 from frame to frame; 0 where there are too few frames."""
    return _mean(video.diff(n=order, dim=1) for video in videos if video.shape[1] > order)


def _mean(several: Iterable[Tensor]) -> float:
    """Mean absolute value of some tensors together, held one at a time; 0 of none."""
    total, count = 0.0, 0
    for values in several:
        total += float(values.abs().sum(dtype=torch.float64))
        count += values.numel()
    return total / max(count, 1)


def ratio(output: float, exemplar: float) -> float:
    """Output / exemplar; where the exemplar has none, 1 plus the output's, so that 1 stays the right answer."""
    return output / exemplar if exemplar else 1 + output
