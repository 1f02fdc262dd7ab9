"""A velocity in time integrated into maps: where what is at each pixel comes from, and where it goes.

A velocity is N flows (2, H, W), x first, in px per step, each constant for a step of 1 / N of the time from 0 to 1.
Pixels are followed along it as particles, in steps by the midpoint rule; what a map then reads is read once, whatever
the number of steps, so nothing is blurred by resampling again and again (semi-Lagrangian integration, as in Beg et
al., Computing large deformation metric mappings via geodesic flows of diffeomorphisms, 2005).
"""

from collections.abc import Callable, Iterator
from typing import Any, Literal

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps.warp import pixel_coordinates

Interpolation = Literal["bilinear", "bicubic"]


def followed(velocity: Tensor, wrap: bool = False, back: bool = False) -> Iterator[Tensor]:
    """How far each pixel's particle has moved after 0, 1, ... N steps of a velocity (N, ..., 2, H, W), one by one.

    Each is (..., 2, H, W), in px. back: particles are followed back in time, from 1 to 0. wrap: the frame is periodic;
    else a particle beyond the border moves as the border does. Differentiable, in the memory of a map for each step.
    """
    pixels = pixel_coordinates(velocity.shape[-2:], velocity.device).to(velocity.dtype)
    sign = -1 if back else 1

    def step(now: Tensor, before: Tensor) -> Tensor:
        place = pixels + before
        half = torch.add(place, interpolated(now, place, wrap=wrap), alpha=sign / 2)
        return torch.add(before, interpolated(now, half, wrap=wrap), alpha=sign)

    moved = torch.zeros_like(velocity[0])
    yield moved
    for now in velocity.unbind()[::sign]:
        moved = again(step, now, moved)
        yield moved


def displaced(velocity: Tensor, wrap: bool = False) -> Tensor:
    """All that `followed` gives, (N + 1, ..., 2, H, W)."""
    return torch.stack(list(followed(velocity, wrap)))


def again(function: Callable[..., Tensor], *given: Tensor) -> Tensor:
    """What a function makes of tensors; for derivatives it is done again, so that only what it is given is kept.

    As `torch.utils.checkpoint`, which needs 80 MB for a compiler that is not used here.
    """
    if not (torch.is_grad_enabled() and any(tensor.requires_grad for tensor in given)):
        return function(*given)
    made: Tensor = _Again.apply(function, *given)
    return made


class _Again(torch.autograd.Function):
    """The function and its derivatives, each made when it is needed."""

    @staticmethod
    def forward(ctx: Any, function: Callable[..., Tensor], *given: Tensor) -> Tensor:
        ctx.function = function
        ctx.save_for_backward(*given)
        return function(*given)

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor | None, ...]:
        given = [tensor.detach().requires_grad_() for tensor in ctx.saved_tensors]
        with torch.enable_grad():
            # of a sum, as derivatives along a given one load a compiler that is not used, for a third of a second
            along = (ctx.function(*given) * gradient).sum()
        return None, *torch.autograd.grad(along, given)


def displacement(velocity: Tensor, start: float, end: float, wrap: bool = False) -> Tensor:
    """How far (2, H, W) the particle that is at each pixel at time `start` has moved at time `end`, both 0 to 1.

    velocity (N, 2, H, W), in px per step. `end` may lie before `start`; a step that they cut counts in part.
    """
    if end < start:
        return displacement(-velocity.flip(0), 1 - start, 1 - end, wrap)
    edges = torch.arange(len(velocity) + 1, dtype=torch.float64)
    within = edges.clamp(start * len(velocity), end * len(velocity))
    share = (within[1:] - within[:-1]).to(velocity)
    used = share > 0
    return displaced(velocity[used] * share[used].view(-1, 1, 1, 1), wrap)[-1] if bool(used.any()) else velocity[0] * 0


def interpolated(image: Tensor, place: Tensor, mode: Interpolation = "bilinear", wrap: bool = False) -> Tensor:
    """Read images (..., C, H, W) at places (..., 2, H, W) in px, x first: (..., C, H, W), differentiable in both.

    As `flow.warp`, which is sharper, reads one image; this is for many at once, and for derivatives.
    """
    flat, place = image.reshape(-1, *image.shape[-3:]), place.reshape(-1, *place.shape[-3:])
    sizes, margin = image.shape[:-3:-1], 0
    if wrap:
        margin = 2  # what bicubic reads beyond a place between the first and the last pixel
        flat, place = F.pad(flat, (margin,) * 4, "circular"), place % place.new_tensor(sizes).view(2, 1, 1)
    # -1 and 1 are the outer borders of the first and the last pixel
    pixels = [2 / (size + 2 * margin) for size in sizes]
    borders = [(margin + 0.5) * pixel - 1 for pixel in pixels]
    scale, shift = place.new_tensor([pixels, borders]).view(2, 2, 1, 1)
    grid = torch.addcmul(shift, place, scale).movedim(1, -1)
    read = F.grid_sample(flat, grid, mode, "border", align_corners=False)
    return read.view(*image.shape[:-2], *read.shape[-2:])


def jacobian(displacement: Tensor, wrap: bool = False) -> Tensor:
    """How much a map that moves pixels by `displacement` (..., 2, H, W) stretches area: the determinant (..., H, W).

    By central differences, one-sided at the border of a frame that is not periodic. 1 where nothing is stretched; 0
    or less where the map folds.
    """
    xx, yx = _derivative(displacement, -1, wrap).unbind(-3)
    xy, yy = _derivative(displacement, -2, wrap).unbind(-3)
    return torch.addcmul((1 + xx) * (1 + yy), xy, yx, value=-1)


def _derivative(values: Tensor, axis: int, wrap: bool) -> Tensor:
    """Central differences along an axis."""
    if wrap:
        return (values.roll(-1, axis) - values.roll(1, axis)) / 2
    return torch.gradient(values, dim=axis)[0]
