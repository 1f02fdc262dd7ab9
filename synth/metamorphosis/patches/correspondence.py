"""Which neighborhoods of two textures correspond (Ruiters et al. 2010, section 4.1): nearest ones, or a transport plan.

Windows are compared by color and by the distance to features, in their principal components. The paper takes for each
window of one texture the nearest of the other, both ways. Some windows then are nobody's nearest, others everybody's.
An entropic optimal transport between the two sets uses all alike (Cuturi, Sinkhorn distances, 2013).
"""

import torch
from torch import Tensor

from kwatra.source import Bag

SOFTNESS = 0.02
"""Entropy of the plan, in mean squared distances of windows; less leads to one partner only. Not tuned."""

_ROUNDS = 60
"""Of scaling the plan's rows and columns: a bound on time."""


def nearest(own: Tensor, other: Bag, count: int) -> Tensor:
    """For windows (N, w, w, C) the numbers (N, count) of the most similar ones of another texture, these first."""
    return other.nearest(other.describe(own), count, "exact")


def transported(first: Bag, second: Bag, count: int) -> tuple[Tensor, Tensor]:
    """The partners of each window of the first (N, count) in the second, and of the second's (M, count) in the first.

    Where the plan puts most of each window's mass, most first. Memory: a few matrices (N, M).
    """
    described = second.describe(first.windows(first.numbers))
    cost = torch.cdist(described.descriptor, second.descriptors).square_()
    cost += (described.remainder[:, None] - second.remainder).square()
    cost /= (SOFTNESS * cost.mean()).clamp(min=1e-12)
    cost -= cost.amin(1, keepdim=True)
    cost -= cost.amin(0, keepdim=True)
    kernel = cost.neg_().exp_()
    rows, columns = kernel.new_ones(len(kernel)), kernel.new_ones(kernel.shape[1]) / kernel.shape[1]
    for _ in range(_ROUNDS):
        rows = 1 / (len(kernel) * (kernel @ columns).clamp(min=1e-30))
        columns = 1 / (kernel.shape[1] * (kernel.T @ rows).clamp(min=1e-30))
    return (kernel * columns).topk(count).indices, (kernel.T * rows).topk(count).indices
