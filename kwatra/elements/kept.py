"""What is found of an exemplar is found once, on the CPU: every try, and every level, asks for it again."""

from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import TypeVar

from torch.utils.weak import WeakTensorKeyDictionary

from kwatra.exemplar import Exemplar

Found = TypeVar("Found")


def kept(find: Callable[[Exemplar], Found]) -> Callable[[Exemplar], Found]:
    """`find`, on the CPU, whose answer is kept for as long as the exemplar's canvas lives."""
    known, finding = WeakTensorKeyDictionary(), RLock()

    @wraps(find)
    def once(exemplar: Exemplar) -> Found:
        with finding:  # tries that are made at once ask at once
            owner, found = known.get(exemplar.canvas, (None, None))
            if owner is not exemplar.owner:
                found = find(exemplar.to("cpu"))
                known[exemplar.canvas] = exemplar.owner, found
            return found

    return once
