"""Tensors of what users give, and where they are to be."""

from typing import Any

import numpy as np
import torch
from torch import Tensor

from kwatra.base.errors import InputError

_WIDEST = 8
"""Bytes of the widest number that torch has."""


def tensor_of(values: Any) -> Tensor:
    """Values as a tensor: a tensor itself, a list or an array of any strides and byte order; derivatives end there.

    Torch takes no array that is flipped or of foreign bytes, and warns of one that may not be written to: those are
    copied. Raises InputError for what is no array of real numbers.
    """
    if isinstance(values, np.ndarray):
        if values.dtype.kind not in "biuf" or values.dtype.itemsize > _WIDEST:
            raise _unfit(values.dtype)
        fit = all(stride >= 0 for stride in values.strides) and values.dtype.isnative and values.flags.writeable
        values = values if fit else np.array(values, values.dtype.newbyteorder("="))
    try:
        made = torch.as_tensor(values)
    except (TypeError, ValueError, RuntimeError):  # no numbers, or lists of unequal length
        raise _unfit(type(values).__name__) from None
    if made.is_complex():
        raise _unfit(made.dtype)
    if made.layout != torch.strided:
        raise InputError("a tensor is sparse; give it as .to_dense() makes it")
    return made.detach() if made.requires_grad else made


def floats_of(values: Any) -> Tensor:
    """The same as the engine's numbers, float32."""
    return tensor_of(values).to(torch.float32)


def device_of(name: torch.device | str) -> torch.device:
    """The device of a name; InputError where there is none such here."""
    try:
        device = torch.device(name)
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError, TypeError) as error:
        said = str(error).partition("\n")[0]
        raise InputError(
            f"the device {str(name)!r} cannot be used ({said}); give 'cpu', or another there is"
        ) from error
    return device


def _unfit(what: object) -> InputError:
    return InputError(
        f"an array holds {what}; give whole or real numbers of up to 64 bits, or booleans, in rows of one length"
    )
