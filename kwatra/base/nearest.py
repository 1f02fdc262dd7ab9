"""What lies nearest."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.utils.weak import WeakTensorKeyDictionary

_FOUND = WeakTensorKeyDictionary()
"""What `nearest_owned` found: a canvas is read in many ways."""


def nearest_known(known: Tensor, spacing: Sequence[float] | None = None) -> Tensor:
    """Where of a mask (*S) the True pixel lies that is nearest to each: (n, *S) long, a row for each of its n axes.

    spacing: from a pixel to the next along each axis; None for 1. Of a mask that is False everywhere it means nothing.
    """
    if bool(known.all()):
        return torch.from_numpy(np.indices(known.shape)).to(known.device)
    from scipy import ndimage  # a tenth of a second that few exemplars need

    unknown = ~known.cpu().numpy()
    places = ndimage.distance_transform_edt(unknown, spacing, return_distances=False, return_indices=True)
    return torch.from_numpy(places).long().to(known.device)


def nearest_owned(owner: Tensor) -> Tensor:
    """For each place of a canvas the nearest pixel that is somebody's, (n, *S) long, row first; kept with owner.

    owner (*S): whose each pixel is, below 0 where nobody's; not to be changed.
    """
    if owner not in _FOUND:
        _FOUND[owner] = nearest_known(owner >= 0)
    found: Tensor = _FOUND[owner]
    return found


def continued(values: Tensor, owner: Tensor) -> Tensor:
    """Values (C, *S) of a canvas, what is nobody's filled in from the nearest pixel; owner as for `nearest_owned`."""
    if bool((owner >= 0).all()):
        return values
    return values[(slice(None), *nearest_owned(owner))]
