"""Cuts too large to be solved at once: coarse first, then only near the coarse seam.

The problem (terminal weights, arcs, free pixels) is contracted by 2 along every axis, which sums what crosses between
blocks and forbids seams inside them: the coarse problem is the fine one restricted to seams along block borders. Its
cut, found the same way, is then bettered among the pixels within `BAND` of it, everything else held. This bounds
memory by the seam's area instead of the volume; the result is the best seam near the coarse one, not always the best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import ndimage

BAND = 3
"""How far, in pixels, the finer cut may move from the coarser one: time grows with it. Tried on random costs only."""

Arcs = Sequence[tuple[np.ndarray, np.ndarray]]
Solver = Callable[[np.ndarray, Arcs, np.ndarray], np.ndarray]


def along(axis: int, low: int | None, high: int | None, dims: int) -> tuple[slice, ...]:
    """The index that takes `low:high` along one axis and everything along the others."""
    return tuple(slice(low, high) if d == axis else slice(None) for d in range(dims))


def solve_in_bands(unary: np.ndarray, arcs: Arcs, free: np.ndarray, solve: Solver, most: int) -> np.ndarray:
    """Which of the free pixels take the new patch, by `solve` on at most about `most` pixels at a time."""
    if np.count_nonzero(free) <= most or min(free.shape) < 4:
        return solve(unary, arcs, free)
    coarse = np.zeros([(n + 1) // 2 for n in free.shape], bool)
    blocks = _blocks(free.shape)
    np.logical_or.at(coarse, blocks, free)
    coarse_unary, coarse_arcs = _contracted(unary, arcs, free)
    take = np.zeros(coarse.shape, bool)
    take[coarse] = solve_in_bands(coarse_unary, coarse_arcs, coarse, solve, most)
    guess = take[blocks] & free
    band = free & _near(guess, free)
    near_unary, near_arcs = _held(unary, arcs, free, guess, band)
    guess[band] = solve(near_unary, near_arcs, band)
    return guess[free]


def _blocks(shape: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    return np.ix_(*[np.arange(n) // 2 for n in shape])


def _pairs(values: np.ndarray, axis: int) -> np.ndarray:
    """Sums of neighboring pairs along an axis, an odd last value alone."""
    return np.add.reduceat(values, np.arange(0, values.shape[axis], 2), axis)


def _contracted(unary: np.ndarray, arcs: Arcs, free: np.ndarray) -> tuple[np.ndarray, Arcs]:
    dims = unary.ndim
    weight = np.where(free, unary, 0)
    for axis in range(dims):
        weight = _pairs(weight, axis)
    result = []
    for axis, pair in enumerate(arcs):
        # Pair i joins pixels i and i + 1, so the odd ones cross from one block to the next.
        crossing = [np.take(arc, range(1, arc.shape[axis], 2), axis) for arc in pair]
        for other in range(dims):
            if other != axis:
                crossing = [_pairs(arc, other) for arc in crossing]
        result.append((crossing[0], crossing[1]))
    return weight, result


def _near(guess: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Pixels within BAND of a border between taken and kept pixels."""
    cross = ndimage.generate_binary_structure(guess.ndim, 1)
    kept = free & ~guess
    reach = [ndimage.binary_dilation(part, cross, iterations=BAND) for part in (guess, kept)]
    near: np.ndarray = reach[0] & reach[1]
    return near


def _held(
    unary: np.ndarray, arcs: Arcs, free: np.ndarray, guess: np.ndarray, band: np.ndarray
) -> tuple[np.ndarray, Arcs]:
    """The problem on `band` alone, the other free pixels held at `guess`."""
    weight, inner = unary.copy(), []
    held = free & ~band
    for axis, (ahead, back) in enumerate(arcs):
        p, q = along(axis, None, -1, free.ndim), along(axis, 1, None, free.ndim)
        both = band[p] & band[q]
        to_held, from_held = band[p] & held[q], held[p] & band[q]
        weight[p] += np.where(to_held, np.where(guess[q], -ahead, back), 0)
        weight[q] += np.where(from_held, np.where(guess[p], -back, ahead), 0)
        inner.append((np.where(both, ahead, 0), np.where(both, back, 0)))
    return weight, inner
