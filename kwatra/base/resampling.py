"""Pictures turned and resized about their center, for every place that does so."""

import math
from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor


def turned(
    stack: Tensor,
    size: tuple[int, int],
    degrees: float,
    factor: float = 1.0,
    mode: str = "bicubic",
    beyond: str = "zeros",
    span: Sequence[int] | None = None,
) -> Tensor:
    """Pictures (..., H, W) turned by `degrees` counterclockwise and enlarged by `factor`: (..., *size), float.

    Centers lie on each other. span: the height and width that the pictures stand for, where they are made smaller
    already; their own by default. mode and beyond: interpolation, and what lies beyond the border, as `mode` and
    `padding_mode` of `torch.nn.functional.grid_sample`.
    """
    height, width = stack.shape[-2:] if span is None else span
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    lines = (torch.arange(side, dtype=torch.float32) - (side - 1) / 2 for side in size)
    y, x = torch.meshgrid(*lines, indexing="ij")
    from_x, from_y = (cos * x - sin * y) / factor, (sin * x + cos * y) / factor
    where = torch.stack([from_x * 2 / width, from_y * 2 / height], -1)[None].to(stack.device)
    flat = stack.reshape(1, -1, *stack.shape[-2:])
    return F.grid_sample(flat, where, mode, beyond, align_corners=False).view(*stack.shape[:-2], *size)
