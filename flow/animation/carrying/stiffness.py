"""The system of equations that makes copies upright (`flow.animation.carrying.upright`), and its solution, compiled.

Its matrix is a diagonal plus what ties neighbors, so a product with it is one pass over the pixels; conjugate gradients
(Hestenes and Stiefel 1952), preconditioned by the diagonal, take one such pass a step and two that sum. Arrays have a
border of one pixel that nothing is tied to.

This module is compiled by numba when first used, so it is imported where a frame is worked on.
"""

from functools import partial
from typing import Any

import numpy as np

from kwatra.base.compiled import jitted

_fast = partial(jitted, fastmath={"reassoc", "contract"})


@_fast
def ties(detail: Any, free: Any, stiffness: Any, axis: int, tied: Any) -> None:
    """Set how much pixels are tied to the next ones along an axis, (H + 2, W + 2), by the lesser detail (H, W).

    Only what is free (H, W) is tied.
    """
    height, width = detail.shape
    for i in range(height - 1 + axis):
        one, other = detail[i], detail[i + 1 - axis]
        here, there = free[i], free[i + 1 - axis]
        for j in range(width - axis):
            least = min(one[j], other[j + axis]) * (here[j] & there[j + axis])
            tied[i + 1, j + 1] = stiffness * least * least


@_fast
def bends(source: Any, beside: Any, axis: int, jump: Any, most: Any, tied: Any, pull: Any) -> None:
    """Add to pull (2, H + 2, W + 2) what undoes the bending of copies along an axis, at most so much of it each pixel.

    source (2, H, W); beside (2, H, W): what copies change by to the right, x first; jump: that between two copies.
    """
    height, width = source.shape[1:]
    for i in range(height - 1 + axis):
        for j in range(width - axis):
            k, n = i + 1 - axis, j + axis
            x, y = (beside[0, i, j], beside[1, i, j]) if axis else (-beside[1, i, j], beside[0, i, j])
            right, down = source[0, k, n] - source[0, i, j] - x, source[1, k, n] - source[1, i, j] - y
            square = right * right + down * down
            if square < jump * jump:
                weight = tied[i + 1, j + 1] / max(np.sqrt(square) / most, np.float32(1))
                pull[0, k + 1, n + 1] -= weight * right
                pull[0, i + 1, j + 1] += weight * right
                pull[1, k + 1, n + 1] -= weight * down
                pull[1, i + 1, j + 1] += weight * down


@_fast
def solve(anchor: Any, tall: Any, wide: Any, residual: Any, tolerance: float, steps: int, solution: Any) -> None:
    """Add to a solution (2, H + 2, W + 2), until what is left of a residual is at most `tolerance` times as long.

    anchor, tall, wide (H + 2, W + 2): the diagonal's own part, and what ties each pixel to the one below and beside.
    """
    diagonal = anchor.copy()
    for i in range(1, len(anchor) - 1):
        for j in range(1, anchor.shape[1] - 1):
            diagonal[i, j] += (tall[i, j] + tall[i - 1, j]) + (wide[i, j] + wide[i, j - 1])
    inverse = 1 / diagonal
    direction, image = np.zeros_like(residual), np.zeros_like(residual)
    energy, length = _step(inverse, np.float32(0), direction, image, residual, solution)
    _turn(inverse, np.float32(0), residual, direction)
    goal = tolerance * tolerance * length
    for _ in range(steps):
        if length <= goal:
            return
        rate = np.float32(energy / _product(diagonal, tall, wide, direction, image))
        before = energy
        energy, length = _step(inverse, rate, direction, image, residual, solution)
        _turn(inverse, np.float32(energy / before), residual, direction)


@_fast
def _product(diagonal: Any, tall: Any, wide: Any, direction: Any, image: Any) -> Any:
    """Set the product of the matrix and a direction; their inner product."""
    total = 0.0
    for c in range(2):
        for i in range(1, len(diagonal) - 1):
            here, above, below = direction[c, i, 1:-1], direction[c, i - 1, 1:-1], direction[c, i + 1, 1:-1]
            left, right, to = direction[c, i, :-2], direction[c, i, 2:], image[c, i, 1:-1]
            own, up, down, behind, ahead = (
                diagonal[i, 1:-1],
                tall[i - 1, 1:-1],
                tall[i, 1:-1],
                wide[i, :-2],
                wide[i, 1:-1],
            )
            part: Any = np.float32(0)
            for j in range(len(to)):
                vertical, across = up[j] * above[j] + down[j] * below[j], behind[j] * left[j] + ahead[j] * right[j]
                value = own[j] * here[j] - vertical - across
                to[j] = value
                part += here[j] * value
            total += part
    return total


@_fast
def _step(inverse: Any, rate: Any, direction: Any, image: Any, residual: Any, solution: Any) -> Any:
    """A step along a direction; what is left, squared, as the diagonal's inverse weighs it and as it is."""
    energy, length = 0.0, 0.0
    for c in range(2):
        for i in range(len(inverse)):
            way, to, line, found, own = direction[c, i], image[c, i], residual[c, i], solution[c, i], inverse[i]
            one: Any = np.float32(0)
            other: Any = np.float32(0)
            for j in range(len(own)):
                found[j] += rate * way[j]
                left = line[j] - rate * to[j]
                line[j] = left
                one += left * left * own[j]
                other += left * left
            energy, length = energy + one, length + other
    return energy, length


@_fast
def _turn(inverse: Any, share: Any, residual: Any, direction: Any) -> None:
    """The next direction: what is left, as the diagonal's inverse weighs it, and a share of the last."""
    for c in range(2):
        for i in range(len(inverse)):
            way, line, own = direction[c, i], residual[c, i], inverse[i]
            for j in range(len(own)):
                way[j] = line[j] * own[j] + share * way[j]
