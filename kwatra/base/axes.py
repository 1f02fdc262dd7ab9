"""What differs between images (two axes) and videos (three): torch's functions by number of axes, and resolutions."""

from collections.abc import Callable, Sequence

import torch.nn.functional as F
from torch import Tensor

AXES = 3
"""Compiled loops see pixels with so many axes: those of an image have one plane."""

CONVOLUTION = {2: F.conv2d, 3: F.conv3d}
AVERAGE = {2: F.avg_pool2d, 3: F.avg_pool3d}
LARGEST = {2: F.max_pool2d, 3: F.max_pool3d}


def factors_of(factor: int, axes: int) -> tuple[int, ...]:
    """A resolution's factor per axis: time, the first of three axes, keeps its resolution (thesis 5.5)."""
    return (1,) * (axes - 2) + (factor,) * 2


def coarse_shape(shape: Sequence[int], factors: Sequence[int]) -> tuple[int, ...]:
    """Shape of an output at a coarser resolution: blocks that the border cuts count as whole."""
    return tuple(-(-size // f) for size, f in zip(shape, factors, strict=True))


def enlarged(image: Tensor, shape: Sequence[int]) -> Tensor:
    """An image (C, *S) interpolated to a larger spatial shape: bicubic, of videos linear; the same one as it is."""
    if tuple(image.shape[1:]) == tuple(shape):
        return image
    mode = "bicubic" if len(shape) == 2 else "trilinear"
    return F.interpolate(image[None], tuple(shape), mode=mode, align_corners=False)[0]


def resized(image: Tensor, factor: tuple[int, ...], shape: tuple[int, ...]) -> Tensor:
    """An image (C, *S) averaged over blocks of `factor` pixels; one that the border cuts repeats its last pixels."""
    padding = []
    for size, f, there in zip(reversed(image.shape[1:]), reversed(factor), reversed(shape), strict=True):
        padding += [0, there * f - size]
    padded = F.pad(image[None], padding, mode="replicate") if any(padding) else image[None]
    return AVERAGE[len(shape)](padded, factor)[0]


def running(largest: Callable[[Tensor, Tensor], Tensor], values: Tensor, width: Sequence[int]) -> Tensor:
    """The `largest` (torch.maximum; or the least) of the values (*S) in every window of `width`, (*S - width + 1).

    Twice as long windows are made of two shorter ones until they are long enough, one axis after the other.
    """
    for axis, whole in enumerate(width):
        reach = 1
        while reach < whole:
            step = min(reach, whole - reach)
            count = values.shape[axis] - step
            values = largest(values.narrow(axis, 0, count), values.narrow(axis, step, count))
            reach += step
    return values
