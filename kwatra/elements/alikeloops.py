"""How far values are from others, by how those vary, and the half of some that is most alike, in compiled loops.

This module is compiled by numba when first used, so it is imported where ground is looked for.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def find_half(values: Any, start: Any, steps: int, least: float, middle: Any, varied: Any) -> None:
    """Set the mean (k,) of a half of values (k, n), and its covariance (k, k): where steps lead from a start (c,).

    The half begins as what is nearest to the start in the first c values; each step takes what is nearest to its mean,
    each direction counted in how much the half varies along it. least: what variances are larger by than they are.
    """
    many, count = values.shape
    away, half, lower = np.zeros(count), np.zeros(count, np.bool_), np.zeros((many, many))
    for n in range(count):
        for i in range(len(start)):
            away[n] += (values[i, n] - start[i]) ** 2
    for _ in range(steps):
        within, changed, held = np.median(away), False, 0
        for n in range(count):
            taken = away[n] <= within
            changed = changed or taken != half[n]
            half[n] = taken
            held += taken
        if not changed:
            break
        _describe(values, half, held, least, middle, varied)
        factor(varied, lower)
        measure(values, middle, lower, away)


@jitted
def _describe(values: Any, half: Any, held: int, least: float, middle: Any, varied: Any) -> None:
    """Set the mean and the covariance of a half (n,), which holds so many values."""
    many, count = values.shape
    middle[:] = 0
    for i in range(many):
        for n in range(count):
            middle[i] += values[i, n] if half[n] else 0.0
        middle[i] /= held
    for i in range(many):
        for j in range(i + 1):
            total = 0.0
            for n in range(count):
                total += (values[i, n] - middle[i]) * (values[j, n] - middle[j]) if half[n] else 0.0
            varied[i, j] = varied[j, i] = total / held + (least if i == j else 0.0)


@jitted
def factor(covariance: Any, lower: Any) -> None:
    """Set the triangle L (k, k): LL' is the covariance (Cholesky)."""
    for i in range(len(lower)):
        for j in range(i + 1):
            rest = covariance[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            lower[i, j] = np.sqrt(rest) if i == j else rest / lower[j, j]


@jitted
def measure(values: Any, middle: Any, lower: Any, away: Any) -> None:
    """Set how far values are from a middle, squared, each direction counted in how much varies along it."""
    even = np.empty(len(values))
    for n in range(len(away)):
        away[n] = 0
        for i in range(len(values)):
            even[i] = values[i, n] - middle[i]
            for k in range(i):
                even[i] -= lower[i, k] * even[k]
            even[i] /= lower[i, i]
            away[n] += even[i] ** 2
