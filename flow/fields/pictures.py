"""Pictures of flow fields: direction as hue, length as saturation, and arrows."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from flow.warps import warp
from kwatra.base import InputError, atan2, check_mask, whole_sizes

Vector = NDArray[np.float64]

_RED, _YELLOW, _GREEN = (1, 0, 0), (1, 1, 0), (0, 1, 0)
_CYAN, _BLUE, _MAGENTA = (0, 1, 1), (0, 0, 1), (1, 0, 1)
_WHEEL = ((_RED, 15), (_YELLOW, 6), (_GREEN, 4), (_CYAN, 11), (_BLUE, 13), (_MAGENTA, 6), (_RED, 0))
_SMOOTH = 4


def picture(flow: Tensor, known: Tensor | None = None, fastest: float | None = None, arrows: int = 0) -> Tensor:
    """A flow (2, H, W) in color, (3, H, W) in [0, 1].

    Hue is the direction on the wheel of the Middlebury benchmark (Baker et al. 2007): red to the right, from there
    clockwise over yellow (down) and cyan (left) to violet (up). White is rest and a full color `fastest` px per frame
    (default: the fastest pixel of all); what is faster still is darker. known (H, W): black where it is False.
    arrows: px from one arrow to the next, each as long as the motion, the fastest one as this distance; 0 for none.

    Raises InputError for another shape, or a `fastest` or `arrows` below 0.
    """
    if flow.ndim != 3 or flow.shape[0] != 2:
        raise InputError(f"a flow has shape {tuple(flow.shape)}; give (2, H, W)")
    if arrows < 0 or (fastest is not None and not fastest > 0):
        raise InputError(
            f"a picture has arrows every {arrows} px and full color at {fastest} px; give positive numbers"
        )
    known = torch.ones_like(flow[0], dtype=torch.bool) if known is None else known
    check_mask(known, flow.shape[1:])
    flow = torch.where(known, flow, 0.0)
    full = float(flow.norm(dim=0).max()) if fastest is None else fastest
    flow = flow / (full or 1.0)
    colors = torch.where(known, _colors(flow), 0.0)
    return colors * (1 - _arrows(flow.cpu(), arrows).to(flow.device)) if arrows else colors


def wheel(size: int) -> Tensor:
    """The key to `picture`: every motion up to the fastest one, (3, size, size), drawn from the middle."""
    (size,) = whole_sizes(size, 1, "the wheel's size")
    place = torch.linspace(-1, 1, size, dtype=torch.float32)
    y, x = torch.meshgrid(place, place, indexing="ij")
    inside = x**2 + y**2 <= 1
    return torch.where(inside, _colors(torch.stack([x, y])), 1.0)


def _colors(flow: Tensor) -> Tensor:
    """Colors (3, H, W) of vectors (2, H, W) whose full length is 1."""
    hues = _hues().to(flow.device)
    turn = atan2(flow[1], flow[0]) / (2 * math.pi) % 1
    hue = warp(hues[:, None], torch.stack([turn * hues.shape[1], torch.zeros_like(turn)]), "bilinear", wrap=True)
    length = flow.norm(dim=0)
    # the fastest pixel's own length may be rounded to just above 1
    return torch.where(length <= 1 + 1e-5, 1 - length.clamp(max=1) * (1 - hue), 0.75 * hue)


def _hues() -> Tensor:
    """The wheel's 55 colors (3, 55): as many between two named ones as the eye tells apart there."""
    steps = [
        torch.lerp(torch.tensor(here, dtype=torch.float32), torch.tensor(there, dtype=torch.float32), k / count)
        for (here, count), (there, _) in pairwise(_WHEEL)
        for k in range(count)
    ]
    return torch.stack(steps, 1)


def _arrows(flow: Tensor, every: int) -> Tensor:
    """How much of each pixel (H, W), 0 to 1, arrows cover."""
    from PIL import Image, ImageDraw

    height, width = flow.shape[1:]
    image = Image.new("L", (width * _SMOOTH, height * _SMOOTH), 0)
    draw = ImageDraw.Draw(image)
    for y in range(every // 2, height, every):
        for x in range(every // 2, width, every):
            along = flow[:, y, x].double().numpy() * every * _SMOOTH
            _arrow(draw, np.array([x + 0.5, y + 0.5]) * _SMOOTH, along, every * _SMOOTH)
    covered = torch.from_numpy(np.array(image.resize((width, height), Image.Resampling.BOX)))
    return covered.float() / 255


def _arrow(draw: Any, start: Vector, along: Vector, room: float) -> None:
    """An arrow from `start`, with a dot where it begins, so that rest is seen, too."""
    thick = max(room / 14, 1.0)
    end, length = start + along, float(np.hypot(*along))
    draw.circle(tuple(start), thick, 255)
    if length <= thick:
        return
    ahead = along / length * min(length, room / 3)
    aside = np.array([-ahead[1], ahead[0]]) * 0.5
    draw.line([tuple(start), tuple(end - ahead * 0.8)], 255, round(thick))
    draw.polygon([tuple(end), tuple(end - ahead + aside), tuple(end - ahead - aside)], 255)
