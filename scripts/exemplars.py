"""The exemplars that scripts work on: two photographs that come with scikit-image, and stones made here."""

import numpy as np
import torch
from skimage import data, transform
from torch import Tensor

_MEET, _ABOVE, _SIDE = 221.2, 1218.5, 512
"""The upright joints of skimage's brick wall meet at this x, so far above the picture, which has so many pixels a side.

Found as what makes the columns of the straight wall differ most."""

_PERSPECTIVE = np.array(
    [[_ABOVE, -_MEET, _MEET * _SIDE], [0, _ABOVE, 0], [0, -1, _ABOVE + _SIDE]],
)
"""From the pixels (x, y) of the straight wall to those of the picture."""


def brick(side: int) -> Tensor:
    """A corner of skimage's brick wall at half its size, (1, side, side)."""
    return _shrunk(data.brick() / 255.0, side)


def wall(side: int) -> Tensor:
    """The corner of skimage's brick wall with its perspective taken out, (1, side, side): all bricks of one width."""
    straight = transform.warp(data.brick() / 255.0, transform.ProjectiveTransform(_PERSPECTIVE), order=3, mode="edge")
    return _shrunk(straight, side)


def gravel(side: int) -> Tensor:
    """A corner of skimage's gravel at half its size, (1, side, side)."""
    return _shrunk(data.gravel() / 255.0, side)


def pebbles(side: int, seed: int = 0) -> Tensor:
    """Stones of four colors, each darker towards its lower right, (3, side, side): the cells of a jittered grid."""
    generator = np.random.default_rng(seed)
    spacing = 14
    grid = np.mgrid[-spacing : side + spacing : spacing, -spacing : side + spacing : spacing].reshape(2, -1).T
    centers = grid + generator.uniform(-6, 6, grid.shape)
    colors = np.array([[0.75, 0.45, 0.30], [0.55, 0.60, 0.62], [0.85, 0.78, 0.60], [0.35, 0.38, 0.45]])
    color = colors[generator.integers(0, len(colors), len(centers))]

    offset = np.mgrid[:side, :side] - centers[:, :, None, None]
    distance = np.sqrt((offset**2).sum(1))
    stone = distance.argmin(0)
    first, second = np.partition(distance, 1, axis=0)[:2]
    to_lower_right = np.take_along_axis(offset.sum(1), stone[None], 0)[0]
    joint = np.clip((second - first) / 3, 0.2, 1)
    grain = 1 + 0.06 * generator.standard_normal((side, side))
    image = color[stone] * ((1 - 0.015 * to_lower_right) * joint * grain)[..., None]
    return torch.from_numpy(image.clip(0, 1).transpose(2, 0, 1)).float()


def _shrunk(image: np.ndarray, side: int) -> Tensor:
    half = transform.rescale(image[: 2 * side, : 2 * side], 0.5, anti_aliasing=True)
    return torch.from_numpy(half).float()[None].clamp(0, 1)
