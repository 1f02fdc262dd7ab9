"""Two labelings of the same pixels fused along the cheapest seam (Lempitsky, Rother, Roth and Blake 2010)."""

import numpy as np
from torch import Tensor

from flow.animation.stock import counted
from kwatra.cut import along, best_cut


def seam_cut(state: Tensor, rough: Tensor, taking: Tensor) -> np.ndarray:
    """Which pixels (H, W) take a new patch in the cheapest labeling, boolean.

    state (H, W): as `kwatra.cut.best_cut` has it. rough: what a seam through each pixel costs; taking: what taking it
    costs, below 0 where it pays; both in variances.
    """
    rough_counts, taking_counts = (counted(values.cpu().numpy()) for values in (rough, taking))
    pairs = []
    for axis in range(2):
        cost = rough_counts[along(axis, None, -1, 2)] + rough_counts[along(axis, 1, None, 2)]
        pairs.append((np.zeros_like(cost), cost, cost))
    return best_cut(state.cpu().numpy(), pairs, taking=taking_counts)
