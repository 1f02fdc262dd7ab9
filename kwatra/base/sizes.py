"""Sizes as users give them."""

from collections.abc import Iterable, Sequence
from typing import Any

from kwatra.base.errors import InputError


def whole_sizes(sizes: Sequence[Any] | Any, axes: int, name: str = "the output's shape") -> tuple[int, ...]:
    """Sizes of so many axes as ints; whole numbers of other types count, 24.0 for 24. InputError for other values."""
    given = tuple(sizes) if isinstance(sizes, Iterable) else (sizes,)
    if len(given) != axes or not all(is_whole(size, 1) for size in given):
        raise InputError(f"{name} is {given}; give {axes} whole numbers of pixels, each at least 1")
    return tuple(int(size) for size in given)


def is_whole(value: Any, least: int) -> bool:
    """Whether something is a whole number, of whatever type, and no less than another."""
    try:
        return bool(int(value) == value >= least)
    except (TypeError, ValueError, OverflowError):  # no number, NaN, infinite
        return False
