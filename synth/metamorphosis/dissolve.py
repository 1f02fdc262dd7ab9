"""A dissolve that keeps contrast: where details of two textures are unlike, their mean is weaker than both."""

import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from kwatra.base import mean

_SCALES = (1.0, 2.0, 4.0)
_GAIN = 1.6


def dissolved(a: Tensor, b: Tensor, part: float) -> Tensor:
    """The mixture (C, H, W) of two frames, `part` of it b, with the contrast of neither lost.

    Where details of the two are unlike their mean is weaker than both. Each band of frequencies (differences of
    Gaussians) is strengthened to the mean of its strengths in the two, by up to 1.6.
    """
    if part in (0, 1):
        return b if part else a
    mixed = torch.lerp(a, b, part)
    bands = [_bands(image) for image in (mixed, a, b)]
    whole = bands[0][-1]
    for both, one, other in zip(*(each[:-1] for each in bands), strict=True):
        strength, left, right = (float(mean(band.square()).sqrt()) for band in (both, one, other))
        gain = ((1 - part) * left + part * right) / max(strength, 1e-9)
        whole = whole + both * min(_GAIN, max(1.0, gain))
    return whole.clamp(0, 1)


def _bands(image: Tensor) -> list[Tensor]:
    """An image (C, H, W) as bands, fine to coarse, that sum to it."""
    blurs = [torch.from_numpy(gaussian_filter(image.numpy(), (0, sigma, sigma))) for sigma in _SCALES]
    return [finer - coarser for finer, coarser in zip([image, *blurs], blurs, strict=False)] + [blurs[-1]]
