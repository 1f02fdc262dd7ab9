"""Sums that are the same bits for any number of threads.

A sum of a whole tensor is split among threads and so rounded differently for another number of them. Summing rows
of fixed length, then the rows' sums, fixes the order.
"""

import torch.nn.functional as F
from torch import Tensor

ROW = 1024


def total(values: Tensor) -> Tensor:
    """Sum of all values, as a scalar tensor."""
    values = values.flatten()
    while len(values) > ROW:
        values = F.pad(values, (0, -len(values) % ROW)).view(-1, ROW).sum(1)
    return values.sum()


def mean(values: Tensor) -> Tensor:
    """Mean of all values, as a scalar tensor."""
    return total(values) / values.numel()
