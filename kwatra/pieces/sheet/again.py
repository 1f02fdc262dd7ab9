"""Laying again where seams cost most, until that no longer helps (thesis section 3.2)."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from kwatra.pieces.boxes import Box
from kwatra.pieces.sheet.sheet import Sheet


@dataclass(frozen=True)
class Budget:
    """When laying again ends: after `steps` patches, `seconds`, or `patience` patches in a row that lowered nothing."""

    steps: int
    patience: int
    seconds: float | None = None


def lay_again(
    sheet: Sheet[Any],
    costly: Callable[[int], Sequence[Box]],
    improve: Callable[[Sequence[Box]], Sequence[bool]],
    budget: Budget,
    report: Callable[[float], None] = lambda part: None,
) -> tuple[list[int], str]:
    """Have something laid over costly regions again and again.

    costly: finds boxes that lie apart, of at most so many costly regions; none where no seam costs anything. improve:
    lays a patch in each where that lowers the seams' cost, and says where it did. report: called with the part of the
    budget that is used, 0..1. Returns the seams' total before and after each step, and why it stopped.
    """
    history, idle, begun = [sheet.total], 0, time.monotonic()
    while True:
        if len(history) > budget.steps:
            return history, f"the budget of {budget.steps} refinement steps was used up"
        if idle >= budget.patience:
            return history, f"the last {idle} patches no longer lowered the total seam cost"
        if budget.seconds is not None and time.monotonic() - begun > budget.seconds:
            return history, f"the budget of {budget.seconds:g} seconds was used up"
        boxes = costly(budget.steps - len(history) + 1)
        if not boxes:
            return history, "no seam costs anything"
        for improved in improve(boxes):
            idle = 0 if improved else idle + 1
            history.append(sheet.total)
        report(min(len(history) / (budget.steps + 1), 1.0))
