"""Tensors of what users give."""

from typing import Any

import numpy as np
import torch
from torch import Tensor


def tensor_of(values: Any) -> Tensor:
    """Values as a tensor: a tensor itself, a list or an array of any strides and byte order.

    Torch takes no array that is flipped or of foreign bytes, and warns of one that may not be written to: those are
    copied.
    """
    if isinstance(values, np.ndarray):
        fit = all(stride >= 0 for stride in values.strides) and values.dtype.isnative and values.flags.writeable
        values = values if fit else np.array(values, values.dtype.newbyteorder("="))
    return torch.as_tensor(values)
