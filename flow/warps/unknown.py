"""Filling in what is not known."""

import torch
from scipy import ndimage
from torch import Tensor
from torch.utils.weak import WeakTensorKeyDictionary

from kwatra.base import check_mask
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
        return _looked_for(known)
    version, found = _FOUND.get(known, (-1, None))
    if version != known._version:
        found = _looked_for(known)
        _FOUND[known] = known._version, found
    return found


def _looked_for(known: Tensor) -> Tensor:
    places = ndimage.distance_transform_edt(~known.cpu().numpy(), return_distances=False, return_indices=True)
    return torch.from_numpy(places).to(known.device)
