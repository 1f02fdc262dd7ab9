"""Filling in what is not known."""

import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import check_mask


def filled(values: Tensor, known: Tensor) -> Tensor:
    """Values (C, H, W) in which every pixel that is not known (H, W) has the value of the nearest known one.

    What the unknown pixels held (NaN, too) does not matter. Raises InputError if nothing is known.
    """
    check_mask(known, values.shape[1:])
    if bool(known.all()):
        return values
    rows, columns = ndimage.distance_transform_edt(~known.cpu().numpy(), return_distances=False, return_indices=True)
    return values[:, torch.from_numpy(rows).to(values.device), torch.from_numpy(columns).to(values.device)]
