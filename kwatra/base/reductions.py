"""Sums, products, powers and angles that are the same bits for any number of threads.

A sum of a whole tensor is split among threads and so rounded differently for another number of them. Summing rows
of fixed length, then the rows' sums, fixes the order.
"""

from collections.abc import Callable

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base.threads import by_one_thread

ROW = 1024
"""Values that are summed at a time."""

_STRETCH = 192
"""Summands of a matrix product that are summed at a time. Not tuned."""

_ALONE = 2**15
"""As many values torch leaves to one thread, whatever is made of each. Not tuned."""


def total(values: Tensor) -> Tensor:
    """Sum of all values, as a scalar tensor."""
    values = values.flatten()
    while len(values) > ROW:
        values = F.pad(values, (0, -len(values) % ROW)).view(-1, ROW).sum(1)
    return values.sum()


def mean(values: Tensor) -> Tensor:
    """Mean of all values, as a scalar tensor."""
    return total(values) / values.numel()


def over_channels(values: Tensor) -> Tensor:
    """Sum of values (C, *S) over the channels, (*S), one after the other.

    `sum` adds five and more in another order where pixels are left over at the end of a thread's share.
    """
    summed = values[0].clone()
    for channel in values[1:]:
        summed += channel
    return summed


def product(a: Tensor, b: Tensor) -> Tensor:
    """The product of matrices (M, K) and (K, N), by one thread.

    Threads would share summands, or rows, of which those at the ends of a share are rounded otherwise on some
    processors.
    """
    with by_one_thread():
        made = a[:, :_STRETCH] @ b[:_STRETCH]
        for first in range(_STRETCH, a.shape[1], _STRETCH):
            made += a[:, first : first + _STRETCH] @ b[first : first + _STRETCH]
    return made


def power(values: Tensor, exponent: float) -> Tensor:
    """Each of some values, of any shape, to a power."""
    return _in_equal_shares(lambda some: some**exponent, values)


def atan2(y: Tensor, x: Tensor) -> Tensor:
    """The angles, from -pi to pi, of vectors whose ordinates and abscissas have one shape (atan2)."""
    return _in_equal_shares(torch.atan2, y, x)


def _in_equal_shares(function: Callable[..., Tensor], *values: Tensor) -> Tensor:
    """What a function makes of each of some values, of any shape.

    Values go through the processor several at once, those left over at the end of a thread's share one by one, and of
    some functions the two ways round differently: so no share is given to another thread.
    """
    shares = zip(*(each.flatten().split(_ALONE) for each in values), strict=True)
    return torch.cat([function(*share) for share in shares]).view(values[0].shape)


def principal_axes(values: Tensor) -> Tensor:
    """The axes, rows of (C, C), along which values (C, N) spread, the one of most spread first."""
    apart = torch.stack([channel - mean(channel) for channel in values])
    spread = torch.stack([torch.stack([total(one * other) for other in apart]) for one in apart])
    return torch.linalg.eigh(spread)[1].T.flip(0)
