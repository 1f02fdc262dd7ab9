"""Work shared among threads, whose results do not depend on how many there are."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import torch

Item = TypeVar("Item")
Made = TypeVar("Made")


def in_threads(work: Callable[[Item], Made], items: Iterable[Item]) -> list[Made]:
    """What `work` makes of each item, in their order, by as many threads as torch has.

    work: changes nothing that another item's needs, and spends its time where Python lets other threads run: in numpy,
    in compiled loops.
    """
    every, threads = list(items), torch.get_num_threads()
    if threads == 1 or len(every) < 2:
        return [work(item) for item in every]
    with ThreadPoolExecutor(min(threads, len(every))) as pool:
        return list(pool.map(work, every))
