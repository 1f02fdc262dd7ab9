"""The two loops of a synthesis: fill the sheet patch by patch, then refine its seams until that no longer helps."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Budget, Sheet, lay_again
from synth.quilting.placement import Placer

Report = Callable[[str, float], None]
"""Called with what is being done and the part of it that is done, 0..1."""


def fill(sheet: Sheet[Mosaic], placer: Placer, grid: tuple[int, ...] | None, report: Report) -> None:
    """Lay patches until no pixel is empty."""
    size, done = sheet.label.size, int(np.count_nonzero(sheet.filled))
    while done < size:
        region = placer.regions.frontier() if done else placer.regions.first()
        patch = placer.choose(region, grid=grid, filling=True)
        if patch is None:
            # Every offset that fits here is spent; a used one is better than a hole.
            placer.used.clear()
            continue
        at = sheet.indices(patch.box)
        done -= int(np.count_nonzero(sheet.filled_at(at)))
        sheet.lay(patch)
        done += int(np.count_nonzero(sheet.filled_at(at)))
        report("filling", done / size)


def refine(
    sheet: Sheet[Mosaic], placer: Placer, budget: Budget, grid: tuple[int, ...] | None, report: Report
) -> tuple[list[int], str]:
    """Lay patches over the costliest seams, accepting those that lower the total (thesis section 3.2).

    Returns what `lay_again` does.
    """

    anywhere = placer.rule.kind == "random"

    def costly(most: int) -> list[Box]:
        region = placer.regions.anywhere() if anywhere else placer.regions.costliest()
        return [] if region is None else [region]

    def improve(regions: Sequence[Box]) -> list[bool]:
        return [lay(region) for region in regions]

    def lay(region: Box) -> bool:
        patch = placer.choose(region, grid=grid)
        lower = patch is not None and sheet.lay(patch, cheaper=True)
        placer.regions.rest(region)
        return lower

    return lay_again(sheet, costly, improve, budget, lambda part: report("refining", part))
