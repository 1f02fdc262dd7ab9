"""Patch fitting by minimum cut (thesis section 3.1), in any number of dimensions.

Every pixel either keeps its old patch (0) or takes the new one (1). A pair of neighbors (s, t) costs

    keep, keep: a = M(s, t, A_s, A_t)     an old seam remembered (0 where both come from one patch)
    keep, take: b = M(s, t, A_s, B)       take, keep: c = M(s, t, B, A_t)       take, take: 0

The thesis hangs a seam node between s and t, with arcs b and c to the pixels and a to the new patch. Here that node is
eliminated: the same minimum is reached by arcs s -> t and t -> s that sum to b + c - a, and the rest on the arcs to the
terminals; one node and two arcs fewer per old seam. With a metric, b + c >= a always. With the cost M' it may fail, and
then a counts as b + c in the cut, which is just what the seam node does; an accepted cut still never costs more than
keeping everything. Constraint arcs are nodes that are not free: their choice is folded into their neighbors' terminals.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from kwatra.cut.bands import Arcs, solve_in_bands
from kwatra.cut.choices import FREE, TAKE

MOST_AT_ONCE = 100_000
"""Cuts over more free pixels than this that hang together are solved coarse to fine (kwatra.cut.bands): faster, and
bounded in memory. In three dimensions a third of it is the limit, for there a flow takes far longer."""

Costs = tuple[np.ndarray, np.ndarray, np.ndarray]


def best_cut(
    choice: np.ndarray,
    pairs: Sequence[Costs],
    taking: np.ndarray | None = None,
) -> np.ndarray:
    """Which pixels take the new patch in the cheapest labeling; boolean, shaped as `choice`.

    `choice`: KEEP, TAKE, FREE or VOID per pixel. `pairs`: per axis the integer costs (a, b, c), of 32 bits, of the
    pairs (p, p + 1 along the axis), one shorter than `choice` along that axis. `taking`: what a pixel costs more when
    it takes than when it keeps, integer, shaped as `choice`. Of several cheapest labelings the one that takes fewest
    pixels.
    """
    from kwatra.cut.network import at_once, energy

    free = choice == FREE
    if solved_at_once(choice) or _largest_part(free) <= _most(choice):
        return at_once(choice, pairs, taking)
    unary, arcs = energy(choice, pairs)
    if taking is not None:
        unary += taking
    take: np.ndarray = choice == TAKE
    if (unary[free] < 0).any():
        take[free] = solve_in_bands(unary, arcs, free, _solve, _most(choice))
    return take


def solved_at_once(choice: np.ndarray) -> bool:
    """Whether a cut has so few free pixels that it is solved as one network, however they hang together."""
    return choice.size <= _most(choice) or int(np.count_nonzero(choice == FREE)) <= _most(choice)


def _largest_part(free: np.ndarray) -> int:
    """How many free pixels hang together at most: parts that do not are cut as if each were alone."""
    parts, _ = ndimage.label(free)
    return int(np.bincount(parts[free]).max())


def _most(choice: np.ndarray) -> int:
    return MOST_AT_ONCE if choice.ndim < 3 else MOST_AT_ONCE // 3


def seams_after(choice: np.ndarray, take: np.ndarray, pairs: Sequence[Costs]) -> list[np.ndarray]:
    """The cost of each pair, per axis, once the pixels in `take` have taken the new patch; int32."""
    from kwatra.cut.network import left_after

    return left_after(choice, take, pairs)


def _solve(unary: np.ndarray, arcs: Arcs, free: np.ndarray) -> np.ndarray:
    """Which of the free pixels take the new patch: they lie on its terminal's side of the minimum cut."""
    from kwatra.cut.flow import sink_side
    from kwatra.cut.network import table

    return sink_side(unary[free], *table(arcs, free))
