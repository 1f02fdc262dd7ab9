"""Windows as rows of a flat image: where in memory each begins, without copying any."""

import torch
from torch import Tensor

from kwatra.windows.layout import Layout


def strides(shape: tuple[int, ...], channels: int) -> Tensor:
    """Values from one pixel to the next along each axis of a contiguous channels-last image (*shape, C)."""
    steps = [channels]
    for size in reversed(shape[1:]):
        steps.append(steps[-1] * size)
    return torch.tensor(steps[::-1])


def starts(corners: Tensor, shape: tuple[int, ...], channels: int) -> Tensor:
    """Where windows with these first pixels (..., n) begin in a contiguous channels-last image (*shape, C): (...)."""
    start = torch.zeros_like(corners[..., 0])
    for along, step in zip(corners.unbind(-1), strides(shape, channels).tolist(), strict=True):
        start.add_(along, alpha=step)
    return start


def row_starts(
    shape: tuple[int, ...], width: tuple[int, ...], channels: int, device: torch.device | str = "cpu"
) -> Tensor:
    """Where each row (along the last axis) of a window begins, from the window's first value: (rows,)."""
    starts = torch.zeros(1, dtype=torch.long, device=device)
    for size, step in zip(width[:-1], strides(shape, channels)[:-1].tolist(), strict=True):
        starts = (starts[:, None] + torch.arange(size, device=device) * step).flatten()
    return starts


def continued(pixels: Tensor, layout: Layout) -> Tensor:
    """A channels-last image (*S, C), for layouts that wrap continued past its far borders as far as windows reach."""
    for axis, (width, wraps) in enumerate(zip(layout.width, layout.wraps, strict=True)):
        if wraps:
            pixels = torch.cat([pixels, pixels.narrow(axis, 0, width - 1)], axis)
    return pixels.contiguous()


def folded(pixels: Tensor, layout: Layout) -> Tensor:
    """The transpose of `continued`: what lies past the far borders added to where it belongs."""
    for axis, size in enumerate(layout.shape):
        past = pixels.shape[axis] - size  # less than the size: windows are no longer than the image
        pixels.narrow(axis, 0, past).add_(pixels.narrow(axis, size, past))
        pixels = pixels.narrow(axis, 0, size)
    return pixels
