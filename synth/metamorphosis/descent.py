"""Descent of an energy that never rises: memoryless BFGS with a backtracking line search.

Nocedal and Wright, Numerical Optimization, 2006, section 7.2, that is their algorithm 7.4 with only the last step kept,
and algorithm 3.1. A step is taken when it lowers the energy enough (Armijo's condition); where the energy is infinite,
as where maps fold, it is shortened. On the six pairs that `Search` was tuned on (see `synth.metamorphosis.velocity`)
four steps kept, for eight more controls in memory, find energies that are the same but for 1.5%, either way.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import total

_ENOUGH = 1e-4
"""The share of what the slope promises that a step has to gain, as is usual (Armijo's rule)."""
_SHORTENINGS = 12
"""So often a step is halved before the search ends."""
_FIRST, _LONGEST = 0.25, 2.0
"""How far, in px, the first step moves a pixel, and any step at most."""

Oracle = Callable[[Tensor], tuple[float, Tensor]]
"""The energy at a point and its gradient there; an infinite energy for points that are not allowed."""


@dataclass(frozen=True)
class Point:
    """A point of the descent, its energy, and the gradient there."""

    at: Tensor
    energy: float
    gradient: Tensor


def inner(a: Tensor, b: Tensor) -> Tensor:
    """Inner product of two controls (N, 2, H, W): the same bits whichever end of time comes first."""
    each = torch.stack([total(x * y) for x, y in zip(a, b, strict=True)])
    return (each + each.flip(0)).sum() / 2


def descent(oracle: Oracle, start: Tensor, reach: Callable[[Tensor], float]) -> Iterator[Point]:
    """The points of a descent, `start` first, each lower than the one before; ends where no step lowers the energy.

    start: a control at which the energy is finite. reach: how far, in px, a change of the control moves pixels.
    """
    point, last = Point(start, *oracle(start)), None
    del start
    yield point
    while True:
        direction = _direction(point.gradient, last)
        far = max(reach(direction), 1e-12)
        direction *= min(_LONGEST / far, _FIRST / far if last is None else 1.0)
        after = _lower(oracle, point, direction)
        if after is None:
            if last is None:
                return
            last = None  # the curvature misleads: once more along the gradient
            continue
        step, change = after.at - point.at, after.gradient - point.gradient
        if float(inner(step, change)) > 0:
            last = step, change
        point = after
        yield point


def _lower(oracle: Oracle, point: Point, direction: Tensor) -> Point | None:
    """The first point along a direction, halved again and again, that is low enough; None if there is none."""
    slope, length = float(inner(point.gradient, direction)), 1.0
    if not slope < 0:
        return None
    for _ in range(_SHORTENINGS):
        at = torch.add(point.at, direction, alpha=length)
        energy, gradient = oracle(at)
        if energy <= point.energy + _ENOUGH * length * slope and energy < point.energy:
            return Point(at, energy, gradient)
        length /= 2
    return None


def _direction(gradient: Tensor, last: tuple[Tensor, Tensor] | None) -> Tensor:
    """The quasi-Newton direction: minus the inverse Hessian that the last step suggests, times the gradient."""
    direction = -gradient
    if last is None:
        return direction
    step, change = last
    curved = float(inner(step, change))
    share = float(inner(step, direction)) / curved
    direction.add_(change, alpha=-share).mul_(curved / float(inner(change, change)))
    return direction.add_(step, alpha=share - float(inner(change, direction)) / curved)
