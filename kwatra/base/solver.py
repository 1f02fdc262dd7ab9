"""Linear systems too large to be written down: conjugate gradients."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base.reductions import total


@dataclass(frozen=True)
class Solution:
    """What a solver reached: x, its residual |right - system(x)| / |right|, and the steps that took.

    Residual 0 after 0 steps: a solution in closed form.
    """

    x: Tensor
    residual: float = 0.0
    steps: int = 0


def conjugate_gradients(
    system: Callable[[Tensor], Tensor],
    right: Tensor,
    diagonal: Tensor,
    start: Tensor,
    tolerance: float = 1e-4,
    steps: int = 500,
) -> Solution:
    """Solve system(x) = right for a symmetric positive definite linear map, preconditioned by its diagonal.

    Stops when the residual is at most `tolerance`, after `steps` steps (Hestenes and Stiefel 1952), or where rounding
    lets it come no nearer. The residual is measured on x, as the one that the recursion carries along drifts away from
    it; where it turns out to be larger than asked, the recursion begins anew.
    """
    size = _norm(right)
    if size == 0:
        return Solution(torch.zeros_like(right))
    x, taken, residual = start, 0, right - system(start)
    reached, before = _norm(residual) / size, math.inf
    while tolerance < reached < before and taken < steps:
        x, more = _run(system, residual, diagonal, x, tolerance * size, steps - taken)
        residual, taken, before = right - system(x), taken + more, reached
        reached = _norm(residual) / size
    return Solution(x, reached, taken)


def _run(
    system: Callable[[Tensor], Tensor], residual: Tensor, diagonal: Tensor, x: Tensor, goal: float, most: int
) -> tuple[Tensor, int]:
    """x improved until the recursion's residual is at most `goal` long, and in how many steps."""
    direction = step = residual / diagonal
    energy = total(residual * step)
    for taken in range(most):
        if _norm(residual) <= goal:
            return x, taken
        image = system(direction)
        length = energy / total(direction * image)
        x = x + length * direction
        residual = residual - length * image
        step = residual / diagonal
        previous, energy = energy, total(residual * step)
        direction = step + energy / previous * direction
    return x, most


def _norm(values: Tensor) -> float:
    return float(total(values.square()).sqrt())
