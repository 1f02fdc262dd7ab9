"""The one error that bad input raises, and what a mask must be."""

from collections.abc import Sequence

import torch
from torch import Tensor


class InputError(ValueError):
    """Something the caller gave cannot be used.

    The message is one sentence: what was given, what it may be, and what to do.
    """


def check_mask(mask: Tensor, shape: Sequence[int]) -> None:
    """Refuse with InputError a mask that is not boolean of this spatial shape, or is False everywhere."""
    if not isinstance(mask, Tensor):
        raise InputError(f"a mask is {type(mask).__name__}; give a tensor of booleans of shape {tuple(shape)}")
    if mask.dtype != torch.bool or tuple(mask.shape) != tuple(shape):
        raise InputError(
            f"a mask has shape {tuple(mask.shape)} and type {mask.dtype}; give booleans of shape {tuple(shape)}, True "
            "where texture belongs"
        )
    if not bool(mask.any()):
        raise InputError("a mask covers every pixel; it is True where texture belongs, so leave some True")
