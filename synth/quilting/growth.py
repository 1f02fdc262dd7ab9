"""The two loops of a synthesis: fill the sheet patch by patch, then refine its seams until that no longer helps."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.sheet import Sheet
from synth.quilting.placement import Placer

Report = Callable[[str, float], None]
"""Called with what is being done and the part of it that is done, 0..1."""


@dataclass(frozen=True)
class Budget:
    """When refining ends: after `steps` patches, `seconds`, or `patience` patches in a row that lowered nothing."""

    steps: int
    patience: int
    seconds: float | None = None


def fill(sheet: Sheet[Mosaic], placer: Placer, grid: tuple[int, ...] | None, report: Report) -> None:
    """Lay patches until no pixel is empty."""
    size = sheet.label.size
    while not sheet.filled.all():
        started = bool(sheet.filled.any())
        region = placer.regions.frontier() if started else placer.regions.first()
        patch = placer.choose(region, grid=grid, filling=True)
        if patch is None:
            # Every offset that fits here is spent; a used one is better than a hole.
            placer.used.clear()
            continue
        sheet.lay(patch)
        report("filling", int(sheet.filled.sum()) / size)


def refine(
    sheet: Sheet[Mosaic], placer: Placer, budget: Budget, grid: tuple[int, ...] | None, report: Report
) -> tuple[list[int], str]:
    """Lay patches over the costliest seams, accepting those that lower the total (thesis section 3.2).

    Returns the total seam cost after each step, the start first, and why it stopped.
    """
    regions = placer.regions
    history, idle, begun = [sheet.total], 0, time.monotonic()
    while True:
        if len(history) > budget.steps:
            return history, f"the budget of {budget.steps} refinement steps was used up"
        if idle >= budget.patience:
            return history, f"the last {idle} patches no longer lowered the total seam cost"
        if budget.seconds is not None and time.monotonic() - begun > budget.seconds:
            return history, f"the budget of {budget.seconds:g} seconds was used up"
        region = regions.anywhere() if placer.rule.kind == "random" else regions.costliest()
        if region is None:
            return history, "no seam costs anything"
        patch = placer.choose(region, grid=grid)
        idle = 0 if patch is not None and sheet.lay(patch, cheaper=True) else idle + 1
        regions.rest(region)
        history.append(sheet.total)
        report("refining", min(len(history) / (budget.steps + 1), 1.0))
