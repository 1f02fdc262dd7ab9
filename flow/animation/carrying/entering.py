"""Texture that enters an empty frame: how its front advances along the flow (thesis section 6.3)."""

import math

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import Lookup, warp

SIDES = ("left", "right", "top", "bottom", "all")
"""Where texture may enter an empty frame from."""


def entered(flow: Tensor, look: Lookup, inside: Tensor, allowed: Tensor, side: str, number: int) -> Tensor:
    """Where (H, W) there is texture in the frame after `number`, of which `inside` (H, W) has some.

    flow (2, H, W), forward, and its lookup; allowed (H, W): False where an obstacle is. Texture comes from beyond
    `side`, one of SIDES, and from where there is some; at another side it is continued by what flows in beside it.
    Of a front that advances by a fraction of a pixel, the pixel before it is reached in that share of the frames, by
    a threshold that runs evenly through all values (the additive recurrence of the golden ratio). Beside an obstacle,
    where the flow rests and would leave a wake empty for ever, texture spreads from pixel to pixel, as fast as the
    flow is elsewhere and by at most one a frame.
    """
    threshold = 0.01 + 0.98 * (number * (math.sqrt(5) - 1) / 2 % 1)
    arrives = _read(inside, look, "bilinear") > threshold
    if not bool(allowed.all()) and float(flow.norm(dim=0).max()) > threshold:
        arrives |= (_read(_spread(~allowed), look) > 0) & (_read(_spread(inside), look) > 0)
    return arrives | enters(flow, side)


def known_of(look: Lookup, inside: Tensor) -> Lookup:
    """The lookup, known only where it leads to texture."""
    return Lookup(look.coordinates, look.known & (_read(inside, look) > 0))


def enters(flow: Tensor, side: str) -> Tensor:
    """Where (H, W) a flow (2, H, W) comes from beyond a side of the frame, one of SIDES."""
    height, width = flow.shape[1:]
    x = torch.arange(width) - flow[0]
    y = torch.arange(height)[:, None] - flow[1]
    beyond = {"left": x < 0, "right": x > width - 1, "top": y < 0, "bottom": y > height - 1}
    return torch.stack(list(beyond.values())).any(0) if side == "all" else beyond[side]


def _read(mask: Tensor, look: Lookup, mode: str = "nearest") -> Tensor:
    return warp(mask[None].float(), look.coordinates, mode)[0]


def _spread(mask: Tensor) -> Tensor:
    """A mask (H, W) and the pixels around it."""
    return F.max_pool2d(mask[None].float(), 3, 1, 1)[0] > 0
