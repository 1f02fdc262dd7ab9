"""Which pattern becomes which: least summed squared way of the centroids (Liu et al. 2002, 4.3, equations 7 to 9)."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from flow.warps import free_form, warp
from synth.metamorphosis.assignment import assigned
from synth.metamorphosis.patterns.outlines import best_order, clockwise

Array = NDArray[np.float64]

SEED = 0.15
"""Size, as a share of the pattern's, of what a pattern without partner grows from or shrinks to."""


@dataclass(frozen=True)
class Correspondence:
    """Landmarks (n, m, 2) of all patterns in A and in B: pairs first, then what has a partner in one of them only."""

    in_a: Array
    in_b: Array
    pairs: int

    def at(self, t: float, scale: float = 1.0) -> Array:
        """Landmarks (n, m, 2) a part t, 0 to 1, of the way from A to B, their patterns scaled about the centroids."""
        between = (1 - t) * self.in_a + t * self.in_b
        middle = between.mean(1, keepdims=True)
        return middle + scale * (between - middle)


def corresponding(a: Array, b: Array, size: tuple[int, int], closed: bool) -> Correspondence:
    """The correspondence of patterns a (n, m, 2) and b (n', m, 2) in a frame of (height, width).

    closed: they are outlines, paired in their best order. A pattern without partner is paired with a seed: itself,
    small, at the place that the warp of the partners around it gives; so it grows from between its neighbors.
    """
    rows, columns = assigned(a.mean(1), b.mean(1))
    from_a, from_b = a[rows], b[columns]
    if closed:
        from_b = _ordered(from_a, from_b)
    seeds_b = _seeds(np.delete(a, rows, 0), from_a, from_b, size)
    seeds_a = _seeds(np.delete(b, columns, 0), from_b, from_a, size)
    return Correspondence(
        np.concatenate([from_a, np.delete(a, rows, 0), seeds_a]),
        np.concatenate([from_b, seeds_b, np.delete(b, columns, 0)]),
        len(rows),
    )


def _ordered(outlines: Array, others: Array) -> Array:
    """The others' landmarks in the order that fits; both (n, m, 2)."""
    opposite = clockwise(outlines) != clockwise(others)
    others = np.where(opposite[:, None, None], others[:, ::-1], others)
    return np.take_along_axis(others, best_order(outlines, others)[..., None], 1)


def _seeds(lonely: Array, here: Array, there: Array, size: tuple[int, int]) -> Array:
    """Where patterns (k, m, 2) of one texture lie, small, in the other, in which `here` (n, m, 2) is `there`."""
    if not len(lonely):
        return lonely
    points, ways = (torch.from_numpy(each.reshape(-1, 2)) for each in (here, there - here))
    middle = lonely.mean(1)
    field = free_form(points, ways, size, repeats=1)  # smooth, where landmarks of neighbors contradict each other
    moved = warp(field, torch.from_numpy(middle.T), "bilinear").T.numpy()
    return (middle + moved)[:, None] + SEED * (lonely - middle[:, None])
