"""What the tests of flowing textures share: bricks, and frames of them."""

import numpy as np
import torch
from skimage import data
from torch import Tensor

import flow
from flow.animation.settings import Renewing
from kwatra import Exemplar

SHAPE = (64, 72)
QUICK = Renewing(blocks=6, block=32, window=16, step=8)
LONG = Renewing(blocks=6, window=24, step=12, interpolation="bicubic")


def brick(side: int = 80) -> Tensor:
    wall = data.brick()[: 2 * side, : 2 * side].astype(np.float32) / 255
    return torch.from_numpy(wall.reshape(side, 2, side, 2).mean((1, 3)))[None]


def animated(field: flow.Field, frames: int = 4, exemplar: Exemplar | Tensor | None = None, **how) -> list[flow.Frame]:
    given = brick() if exemplar is None else exemplar
    return list(flow.animate(given, field, SHAPE, frames=frames, **{"renewing": QUICK, **how}))
