"""What is found of an exemplar is found once, on the CPU: every try, and every level, asks for it again."""

import math
from collections.abc import Callable
from functools import wraps
from threading import RLock
from typing import TypeVar

from torch.utils.weak import WeakTensorKeyDictionary

from kwatra.exemplar import Exemplar

Found = TypeVar("Found")


def kept_up_to(pixels: float) -> Callable[[Callable[[Exemplar], Found]], Callable[[Exemplar], Found]]:
    """What makes `find` keep its answers for as long as an exemplar's canvas lives, which has up to so many pixels.

    Of a larger one it is found anew each time. It is looked for on the CPU.
    """

    def keeping(find: Callable[[Exemplar], Found]) -> Callable[[Exemplar], Found]:
        known, finding = WeakTensorKeyDictionary(), RLock()

        @wraps(find)
        def once(exemplar: Exemplar) -> Found:
            if exemplar.owner.numel() > pixels:
                return find(exemplar.to("cpu"))
            with finding:  # tries that are made at once ask at once
                owner, found = known.get(exemplar.canvas, (None, None))
                if owner is not exemplar.owner:
                    found = find(exemplar.to("cpu"))
                    known[exemplar.canvas] = exemplar.owner, found
                return found

        return once

    return keeping


def kept(find: Callable[[Exemplar], Found]) -> Callable[[Exemplar], Found]:
    """`find`, on the CPU, whose answer is kept for as long as the exemplar's canvas lives."""
    return kept_up_to(math.inf)(find)
