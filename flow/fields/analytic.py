"""Fields by formula: uniform, rotation, sink, source, saddle, shear, a vortex pair, a stream, waves, and noise.

Each is centered on the frame and scaled to it, and its fastest pixel moves `speed` px per frame. `angle` turns a field
clockwise on the screen, in degrees. All but sink and source are free of divergence; those that are not affine come
from a stream function psi as (dpsi/dy, -dpsi/dx).
"""

import math

import torch
from torch import Tensor

from flow.fields.field import Field, Shape, at_speed
from flow.warps import pixel_coordinates
from kwatra.base import InputError, generator_of

_WAVES = 24
"""Of how many plane waves noise is the sum."""


def uniform(speed: float = 2.0, angle: float = 0.0) -> Field:
    """Every pixel moves in the direction of `angle`."""
    return at_speed(
        lambda t, shape: turned(
            torch.stack([torch.ones(shape, dtype=torch.float32), torch.zeros(shape, dtype=torch.float32)]), angle
        ),
        speed,
    )


def rotation(speed: float = 2.0) -> Field:
    """The frame turns about its center, clockwise."""
    return at_speed(lambda t, shape: turned(_centered(shape), 90), speed)


def source(speed: float = 2.0) -> Field:
    """Everything flows out of the frame's center, the faster the farther from it."""
    return at_speed(lambda t, shape: _centered(shape), speed)


def sink(speed: float = 2.0) -> Field:
    """Everything flows into the frame's center, the faster the farther from it."""
    return source(-speed)


def saddle(speed: float = 2.0, angle: float = 0.0) -> Field:
    """The texture is drawn out along `angle` and drawn in across it."""

    def formula(t: float, shape: Shape) -> Tensor:
        along, across = _centered(shape, angle)
        return turned(torch.stack([along, -across]), angle)

    return at_speed(formula, speed)


def shear(speed: float = 2.0, angle: float = 0.0) -> Field:
    """Everything moves along `angle`, the two halves of the frame against each other."""

    def formula(t: float, shape: Shape) -> Tensor:
        across = _centered(shape, angle)[1]
        return turned(torch.stack([across, 0 * across]), angle)

    return at_speed(formula, speed)


def vortices(speed: float = 2.0, angle: float = 0.0) -> Field:
    """A pair of vortices that turn against each other and drive a jet along `angle` between them."""

    def formula(t: float, shape: Shape) -> Tensor:
        along, across = _centered(shape, angle)
        apart, core = min(shape) / 4, min(shape) / 10
        squares = [along**2 + (across - side) ** 2 + core**2 for side in (apart, -apart)]
        x = (across + apart) / squares[1] - (across - apart) / squares[0]
        return turned(torch.stack([x, along / squares[0] - along / squares[1]]), angle)

    return at_speed(formula, speed)


def stream(speed: float = 2.0, angle: float = 0.0) -> Field:
    """A river that crosses the frame along `angle` and bends on its way; beside it everything rests."""

    def formula(t: float, shape: Shape) -> Tensor:
        along, across = _centered(shape, angle)
        wave, bend, half = 2 * math.pi / max(shape), min(shape) / 6, min(shape) / 5
        current = torch.exp(-(((across + bend * torch.cos(wave * along)) / half) ** 2))
        return turned(torch.stack([current, current * bend * wave * torch.sin(wave * along)]), angle)

    return at_speed(formula, speed)


def waves(speed: float = 2.0, angle: float = 0.0, wavelength: float | None = None, period: float = 50.0) -> Field:
    """Waves that travel along `angle` and swing the texture across it.

    wavelength: in px (default: half the frame's shorter side). period: frames until all is as before.
    """
    _check_positive(wavelength=wavelength, period=period)

    def formula(t: float, shape: Shape) -> Tensor:
        along = _centered(shape, angle)[0]
        swing = torch.sin(2 * math.pi * (along / (wavelength or min(shape) / 2) - t / period))
        return turned(torch.stack([0 * swing, swing]), angle)

    return at_speed(formula, speed, steady=False)


def noise(speed: float = 2.0, scale: float | None = None, period: float | None = None, seed: int = 0) -> Field:
    """Curl noise: eddies without any pattern, free of divergence (the idea: Bridson, Hourihan and Nordenstam 2007).

    The stream function is a sum of plane waves of random direction and phase. scale: their wavelength in px,
    between it and twice as much (default: a third of the frame's shorter side). period: frames until all is as before;
    None for a steady field. seed: another seed, other eddies.
    """
    _check_positive(scale=scale, period=period)
    generator = generator_of(seed)
    turn, phase, octave, pace = torch.rand(4, _WAVES, generator=generator, dtype=torch.float64)
    cycles = torch.where(pace < 0.5, -1, 1) * (1 + (2 * pace % 1 * 2).floor())

    def formula(t: float, shape: Shape) -> Tensor:
        x, y = _centered(shape)
        number = 2 * math.pi / ((scale or min(shape) / 3) * 2**octave)
        flow = torch.zeros(2, *shape, dtype=torch.float32)
        for k in range(_WAVES):
            kx, ky = number[k] * torch.cos(2 * math.pi * turn[k]), number[k] * torch.sin(2 * math.pi * turn[k])
            angle = 2 * math.pi * (phase[k] + (0 if period is None else cycles[k] * t / period))
            # a wave of height 1/k^2, so that large eddies are the strong ones
            slope = torch.cos(x * float(kx) + y * float(ky) + float(angle)) / float(number[k]) ** 2
            flow += torch.stack([slope * float(ky), slope * -float(kx)])
        return flow

    return at_speed(formula, speed, steady=period is None)


def _centered(shape: Shape, angle: float = 0.0) -> Tensor:
    """Pixels' places (2, H, W) from the frame's center, along and across the direction of `angle`."""
    centers = torch.tensor([(shape[1] - 1) / 2, (shape[0] - 1) / 2], dtype=torch.float32).view(2, 1, 1)
    return turned(pixel_coordinates(shape) - centers, -angle)


def turned(vectors: Tensor, angle: float) -> Tensor:
    """Vectors (2, H, W) turned by `angle` degrees, from x to y. Quarter turns are exact."""
    cosine, sine = (round(f(math.radians(angle)), 15) for f in (math.cos, math.sin))
    x, y = vectors
    return torch.stack([cosine * x - sine * y, sine * x + cosine * y])


def _check_positive(**values: float | None) -> None:
    for name, value in values.items():
        if value is not None and not (0 < value < math.inf):
            raise InputError(f"the flow's {name} is {value}; give a positive number")
