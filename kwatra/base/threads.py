"""Work that threads share: calls that do not depend on each other, side by side.

What is called has to let go of the interpreter's lock to gain by it, as compiled loops and transforms do. Each call is
made once, by one thread, so bits depend neither on the number of threads nor on their order.
"""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from typing import TypeVar

import torch

Item = TypeVar("Item")
Made = TypeVar("Made")


class _Told(threading.local):
    """How many threads `shared` has in this thread, None for as many as torch has."""

    threads: int | None = None


_told = _Told()


def threads_shared() -> int:
    """How many threads share work that the calling thread has."""
    return torch.get_num_threads() if _told.threads is None else _told.threads


def shared(call: Callable[[Item], Made], items: Sequence[Item], together: int | None = None) -> list[Made]:
    """What a call makes of each item, in their order, by several threads, of which the calling one is one.

    together: how many calls are under way at a time; None for as many as there are threads. Those are divided among
    them: few calls may share work of their own. Where the others are busy the calling thread does all.
    """
    threads = threads_shared()
    together = min(threads if together is None else together, len(items))
    if threads == 1 or together < 2:
        return [call(item) for item in items]
    each = max(threads // together, 1)
    torchs, ours = (each, None) if _told.threads is None else (1, each)

    def alone(item: Item) -> Made:
        with _using(torchs, ours):  # which each thread has to be told
            return call(item)

    return _by_threads(together, alone, items)


def even_ranges(items: int, parts: int) -> list[tuple[int, int]]:
    """So many items in parts as even as can be, one after the other: from the first of each to after its last."""
    return [(items * k // parts, items * (k + 1) // parts) for k in range(parts)]


@contextmanager
def by_one_thread() -> Iterator[None]:
    """Have torch use the calling thread alone: for small work, and for what threads would round differently."""
    with _using(1, None):
        yield


@contextmanager
def by_our_threads() -> Iterator[None]:
    """Have torch use the calling thread alone and leave the others to `shared`, for what compiled loops do.

    Torch's own threads, once woken, look out for more work for some milliseconds, on processors that others then lack:
    by two threads such loops took .7 of their time by one, in place of half.
    """
    with _using(1, threads_shared()):
        yield


@contextmanager
def _using(torchs: int, threads: int | None) -> Iterator[None]:
    """Have torch use so many threads, and `shared` as many or so many."""
    before = torch.get_num_threads(), _told.threads
    torch.set_num_threads(torchs)
    _told.threads = threads
    try:
        yield
    finally:
        torch.set_num_threads(before[0])
        _told.threads = before[1]


def _by_threads(threads: int, call: Callable[[Item], Made], items: Sequence[Item]) -> list[Made]:
    """What a call makes of each item, in their order, on so many threads."""
    made: dict[int, Made] = {}
    left = iter(range(len(items)))  # the next number goes to whoever asks

    def work() -> None:
        for number in left:
            made[number] = call(items[number])

    pool = _pool(os.getpid())
    helpers = [pool.submit(work) for _ in range(threads - 1)]
    try:
        work()
    finally:
        for _ in left:  # after an error nobody goes on
            pass
        for helper in helpers:
            if not helper.cancel():
                helper.result()
    return [made[number] for number in range(len(items))]


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """The helpers of a process, made as they are needed: a fork has none of its parent's threads."""
    return ThreadPoolExecutor(os.cpu_count())
