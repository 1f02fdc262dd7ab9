"""Randomness from a seed: any whole number from 0 on."""

import hashlib
import operator
from typing import Any

import torch

from kwatra.base.errors import InputError

_HEEDED = 2**32
"""torch's generator on the CPU heeds the lowest 32 bits of its seed, and takes no more than 64."""


def generator_of(seed: int, step: int = 0) -> torch.Generator:
    """A generator for a seed, and for a step of work that needs a beginning of its own.

    Seeds below 2^32 are taken as they are; larger ones, and a step of any seed but 0, are hashed to so many bits.
    Raises InputError for what is no whole number from 0 on.
    """
    seed = whole_seed(seed)
    value = (seed << 32) + step if step else seed
    if value >= _HEEDED:
        value = int.from_bytes(hashlib.sha256(str(value).encode()).digest()[:4], "little")
    return torch.Generator().manual_seed(value)


def whole_seed(seed: Any) -> int:
    """A seed as an int; InputError for what is no whole number from 0 on."""
    try:
        whole = operator.index(seed)
    except TypeError:
        whole = -1
    if whole < 0:
        raise InputError(f"the seed is {seed}; give a whole number from 0 on")
    return whole
