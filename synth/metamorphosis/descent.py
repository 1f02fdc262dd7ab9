"""Descent of an energy that never rises: L-BFGS with a backtracking line search.

Nocedal and Wright, Numerical Optimization, 2006, algorithms 7.4 and 3.1. A step is taken when it lowers the energy
enough (Armijo's condition); where the energy is infinite, as where maps fold, it is shortened.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import total

_KEPT = 4
"""So many steps tell of the curvature, two controls in memory each. On the six pairs that `Search` was tuned on (see
`synth.metamorphosis.velocity`) 6 find energies within 1.5% of these, twice higher ones; 3 up to 5% higher ones."""
_ENOUGH = 1e-4
_SHORTENINGS = 12
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
    point = Point(start, *oracle(start))
    steps: list[tuple[Tensor, Tensor]] = []
    yield point
    while True:
        direction = _direction(point.gradient, steps)
        far = reach(direction)
        direction = direction * min(_LONGEST / max(far, 1e-12), 1.0 if steps else _FIRST / max(far, 1e-12))
        after = _lower(oracle, point, direction)
        if after is None:
            if not steps:
                return
            steps = []  # the curvature misleads: once more along the gradient
            continue
        step, change = after.at - point.at, after.gradient - point.gradient
        if float(inner(step, change)) > 0:
            steps = [*steps, (step, change)][-_KEPT:]
        point = after
        yield point


def _lower(oracle: Oracle, point: Point, direction: Tensor) -> Point | None:
    """The first point along a direction, halved again and again, that is low enough; None if there is none."""
    slope, length = float(inner(point.gradient, direction)), 1.0
    if not slope < 0:
        return None
    for _ in range(_SHORTENINGS):
        at = point.at + length * direction
        energy, gradient = oracle(at)
        if energy <= point.energy + _ENOUGH * length * slope and energy < point.energy:
            return Point(at, energy, gradient)
        length /= 2
    return None


def _direction(gradient: Tensor, steps: list[tuple[Tensor, Tensor]]) -> Tensor:
    """The quasi-Newton direction: minus the inverse Hessian that the last steps suggest, times the gradient."""
    direction, shares = -gradient, []
    for step, change in reversed(steps):
        share = inner(step, direction) / inner(step, change)
        direction = direction - share * change
        shares.append(share)
    if steps:
        step, change = steps[-1]
        direction = direction * (inner(step, change) / inner(change, change))
    for (step, change), share in zip(steps, reversed(shares), strict=True):
        direction = direction + (share - inner(change, direction) / inner(step, change)) * step
    return direction
