"""Compiled loops, for what tensors would need large temporaries for; on the CPU only.

A loop works on a range of its items, so that threads share it; each item is worked on by one thread, in an order of its
own, so bits do not depend on their number. Numba compiles a loop when it is first called and keeps it on the disk.
"""

import hashlib
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any, TypeVar

import torch

from kwatra.base.threads import even_ranges, shared, threads_shared

Function = TypeVar("Function", bound=Callable[..., Any])

_FEW = 256
"""Fewer items than this are not shared among threads."""


def jitted(function: Function, **options: Any) -> Function:
    """A function compiled by numba, kept on the disk where there is a place for it."""
    import numba  # heavy: only where something is computed

    _watch()
    try:
        made: Any = numba.njit(cache=True, nogil=True, **options)(function)
        _keep_apart(made)
    except RuntimeError:  # neither beside the program nor in the user's folder may anything be written
        made = numba.njit(nogil=True, **options)(function)
    kept: Function = made
    return kept


def inlined(function: Function) -> Function:
    """The same for what innermost loops call: it becomes part of them, as to hand on arrays takes long."""
    return jitted(function, forceinline=True)


def compiling() -> bool:
    """Whether some thread compiles a loop now, which no run on this machine had to use before."""
    return _begun > _ended


_begun = _ended = 0
"""How many loops were begun to be compiled, and how many of these are done: numba compiles one at a time."""


@cache
def _watch() -> None:
    """Have numba tell when it compiles; what it finds on the disk it does not tell of."""
    from numba.core import event

    class Watch(event.Listener):
        def on_start(self, event: Any) -> None:
            global _begun
            _begun += 1

        def on_end(self, event: Any) -> None:
            global _ended
            _ended += 1

    event.register("numba:compile", Watch())


def _keep_apart(made: Any) -> None:
    """Have what numba keeps named by types and source: it names by numbers, and finds by types what has a number.

    Two processes that compile a function at once for different types may both take the next number; one of them would
    later be given the other's loop, which reads its arrays wrongly.
    """
    file = getattr(getattr(made, "_cache", None), "_cache_file", None)
    if file is None:  # told to compile nothing, or another numba
        return
    save, names = file.save, file._data_name_pattern

    def save_apart(key: Any, data: Any) -> None:
        what = hashlib.sha256(repr((key, file._source_stamp)).encode()).hexdigest()[:16]
        file._data_name_pattern = names.replace(".{number", f".{what}.{{number")
        save(key, data)

    file.save = save_apart


class Compiled:
    """A function of arrays and numbers that ends with (low, high), the items to work on; compiled at first use."""

    def __init__(self, function: Callable[..., None]) -> None:
        self._function = function

    @cached_property
    def _compiled(self) -> Callable[..., None]:
        return jitted(self._function, fastmath={"reassoc", "contract"})

    def __call__(self, items: int, *arguments: Any) -> None:
        """Work on all items, shared among threads; tensors are given as they are, contiguous on the CPU."""
        arrays = [a.numpy() if isinstance(a, torch.Tensor) else a for a in arguments]
        threads = 1 if items < _FEW else threads_shared()
        shared(lambda part: self._compiled(*arrays, *part), even_ranges(items, threads))
