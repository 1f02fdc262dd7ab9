"""Textures that tests of several folders look at."""

import torch
import torch.nn.functional as F
from skimage import data
from torch import Tensor


def noise(*shape: int, seed: int = 0) -> Tensor:
    """White noise of a shape, in [0, 1)."""
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed))


def gravel(side: int, top: int = 0, shrunk: int = 1) -> Tensor:
    """A part (1, side, side) of a photograph of gravel, in [0, 1], shrunk so many times, from a row on."""
    return F.avg_pool2d(torch.from_numpy(data.gravel()).float()[None] / 255, shrunk)[:, top : top + side, :side]
