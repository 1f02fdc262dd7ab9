"""A loop over offsets between copies, compiled.

This module is compiled by numba when first used, so it is imported where a lattice is asked.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import Compiled

_CLOSER = 1e-9
"""A lattice point has to be closer by so many squared pixels to be taken for another: a bound on rounding."""


@Compiled
def take_nearest(basis: Any, inverse: Any, rest: Any, low: int, high: int) -> None:
    """Take the nearest lattice point from offsets (2, N), in place; basis (2, 2): the lattice's vectors in columns.

    What is no farther from a point than half of the shortest vector is nearer to no other.
    """
    near = np.inf
    for i, j in ((1, 0), (0, 1), (1, 1), (1, -1)):
        y, x = basis[0, 0] * i + basis[0, 1] * j, basis[1, 0] * i + basis[1, 1] * j
        near = min(near, (y * y + x * x) / 4)
    for n in range(low, high):
        down, right = rest[0, n], rest[1, n]
        i = np.rint(inverse[0, 0] * down + inverse[0, 1] * right)
        j = np.rint(inverse[1, 0] * down + inverse[1, 1] * right)
        down -= basis[0, 0] * i + basis[0, 1] * j
        right -= basis[1, 0] * i + basis[1, 1] * j
        if down * down + right * right > near:
            # of a reduced basis the nearest point is the rounded one or one beside it
            for i in range(-1, 2):
                for j in range(-1, 2):
                    y = down - (basis[0, 0] * i + basis[0, 1] * j)
                    x = right - (basis[1, 0] * i + basis[1, 1] * j)
                    if y * y + x * x < down * down + right * right - _CLOSER:
                        down, right = y, x
        rest[0, n], rest[1, n] = down, right
