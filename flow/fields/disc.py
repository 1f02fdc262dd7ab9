"""Flow around a disc, by its formula."""

import math

import torch
from torch import Tensor

from flow.fields.analytic import turned
from flow.fields.edge import Edge
from flow.fields.field import Field, Shape, at_speed
from flow.warps import pixel_coordinates
from kwatra.base import InputError


def disc_mask(shape: Shape, center: tuple[float, float] | None = None, radius: float | None = None) -> Tensor:
    """The mask (H, W) of a disc: False inside it. center (x, y) and radius are in px.

    By default the disc lies in the frame's middle and its radius is a sixth of the frame's shorter side.
    """
    return _from_disc(shape, center).norm(dim=0) > _radius(shape, radius)


def disc(
    speed: float = 2.0,
    angle: float = 0.0,
    center: tuple[float, float] | None = None,
    radius: float | None = None,
) -> Field:
    """Potential flow along `angle` around a disc (see `disc_mask`; Lamb, Hydrodynamics, article 68), at rest inside."""
    if radius is not None and not (0 < radius < math.inf):
        raise InputError(f"the disc's radius is {radius}; give a positive number of pixels")

    def formula(t: float, shape: Shape) -> Tensor:
        x, y = turned(_from_disc(shape, center), -angle)
        square = (x**2 + y**2).clamp(min=1e-6)
        bend = _radius(shape, radius) ** 2 / square**2
        flow = turned(torch.stack([1 - bend * (x**2 - y**2), -2 * bend * x * y]), angle)
        return flow * disc_mask(shape, center, radius)

    flowing = at_speed(formula, speed)
    return Field(lambda t, shape: Edge(disc_mask(shape, center, radius)).keep_out(flowing.at(t, shape)), steady=True)


def _from_disc(shape: Shape, center: tuple[float, float] | None) -> Tensor:
    x, y = center or ((shape[1] - 1) / 2, (shape[0] - 1) / 2)
    return pixel_coordinates(shape) - torch.tensor([x, y], dtype=torch.float32).view(2, 1, 1)


def _radius(shape: Shape, radius: float | None) -> float:
    return min(shape) / 6 if radius is None else radius
