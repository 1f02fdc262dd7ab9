"""Two labelings of the same pixels fused along the cheapest seam (Lempitsky, Rother, Roth and Blake 2010)."""

import numpy as np
from torch import Tensor

from kwatra.cut import along, best_cut

_COUNTS = 10_000
"""Costs are counted in whole numbers, so many to one variance of the exemplar."""

_MOST = 1000.0
"""Costs beyond so many variances are as good as infinite."""


def seam_cut(state: Tensor, rough: Tensor, taking: Tensor) -> np.ndarray:
    """Which pixels (H, W) take a new patch in the cheapest labeling, boolean.

    state (H, W): as `kwatra.cut.best_cut` has it. rough: what a seam through each pixel costs; taking: what taking it
    costs, below 0 where it pays; both in variances.
    """
    rough_counts, taking_counts = (
        (v.clamp(-_MOST, _MOST) * _COUNTS).round().long().cpu().numpy() for v in (rough, taking)
    )
    pairs = []
    for axis in range(2):
        cost = rough_counts[along(axis, None, -1, 2)] + rough_counts[along(axis, 1, None, 2)]
        pairs.append((np.zeros_like(cost), cost, cost))
    return best_cut(state.cpu().numpy(), pairs, taking=taking_counts)
