"""Laying again where seams cost most, until that no longer helps (thesis section 3.2)."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from kwatra.pieces.boxes import Box
from kwatra.pieces.regions import Regions
from kwatra.pieces.sheet import Sheet


@dataclass(frozen=True)
class Budget:
    """When laying again ends: after `steps` patches, `seconds`, or `patience` patches in a row that lowered nothing."""

    steps: int
    patience: int
    seconds: float | None = None


def lay_again(
    sheet: Sheet[Any],
    regions: Regions,
    improve: Callable[[Box], bool],
    budget: Budget,
    *,
    anywhere: bool = False,
    report: Callable[[float], None] = lambda part: None,
) -> tuple[list[int], str]:
    """Have `improve` lay something over the costliest region, or over one `anywhere`, again and again.

    improve: lays a patch over a region where that lowers the seams' cost, and says whether it did. report: called
    with the part of the budget that is used, 0..1. Returns the seams' total before and after each step, and why it
    stopped.
    """
    history, idle, begun = [sheet.total], 0, time.monotonic()
    while True:
        if len(history) > budget.steps:
            return history, f"the budget of {budget.steps} refinement steps was used up"
        if idle >= budget.patience:
            return history, f"the last {idle} patches no longer lowered the total seam cost"
        if budget.seconds is not None and time.monotonic() - begun > budget.seconds:
            return history, f"the budget of {budget.seconds:g} seconds was used up"
        region = regions.anywhere() if anywhere else regions.costliest()
        if region is None:
            return history, "no seam costs anything"
        idle = 0 if improve(region) else idle + 1
        regions.rest(region)
        history.append(sheet.total)
        report(min(len(history) / (budget.steps + 1), 1.0))
