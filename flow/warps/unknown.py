"""Filling in what is not known."""

from torch import Tensor
from torch.utils.weak import WeakTensorKeyDictionary

from kwatra.base import check_mask, nearest_known
from kwatra.source import look_up

_FOUND = WeakTensorKeyDictionary()
"""What `_nearest` found: along a steady flow the same pixels are not known in every frame."""


def filled(values: Tensor, known: Tensor) -> Tensor:
    """Values (C, H, W) in which every pixel that is not known (H, W) has the value of the nearest known one.

    What the unknown pixels held (NaN, too) does not matter. Raises InputError if nothing is known.
    """
    check_mask(known, values.shape[1:])
    if bool(known.all()):
        return values
    return look_up(values, _nearest(known))


def _nearest(known: Tensor) -> Tensor:
    """Row and column (2, H, W) of the known pixel nearest to each; kept for as long as `known` is, and as it is."""
    if known.is_inference():  # whether it is as it was cannot be told
        return nearest_known(known)
    version, found = _FOUND.get(known, (-1, None))
    if version != known._version:
        found = nearest_known(known)
        _FOUND[known] = known._version, found
    return found
