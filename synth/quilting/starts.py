"""Several starts tried out on a small version of the work, and the best laid at full size.

Which patches make good seams shows on a part of a clip as well as on all of it, at a part of the time: a few sequences
of patches are drawn and refined there, and that with the cheapest seams is laid, in the same order, in the whole.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting.growth import Report
from synth.quilting.synthesis import QuiltSettings

STARTS = 4
"""So many starts are tried: time grows with it."""


def cheapest_start(
    begun: Callable[[], Sheet[Mosaic]],
    sew: Callable[[Sheet[Mosaic], QuiltSettings], str],
    settings: QuiltSettings,
    price: Callable[[Sheet[Mosaic]], int] = lambda sheet: sheet.total,
) -> tuple[list[Patch], str]:
    """The patches that are seen in the best of the starts on `begun()`, in order, and why it stopped, as `sew` says.

    `sew` lays them. The best is that of the least `price`. The starts differ by seed, and share the time allowed.
    """
    seconds = None if settings.seconds is None else settings.seconds / STARTS
    trials = []
    for start in range(STARTS):
        own = dataclasses.replace(settings, seed=settings.seed * STARTS + start, seconds=seconds)
        sheet = begun()
        known = len(sheet.patches)
        stopped = sew(sheet, own)
        seen = np.unique(sheet.label)
        trials.append((price(sheet), start, [sheet.patches[k] for k in seen[seen >= known]], stopped))
    _, _, patches, stopped = min(trials)
    return patches, stopped


def lay_all(sheet: Sheet[Mosaic], patches: Sequence[Patch], report: Report) -> list[int]:
    """Lay patches in order, once the sheet is full only where they lower the total; that total after each of those."""
    history: list[int] = []
    for number, patch in enumerate(patches):
        full = bool(sheet.filled.all())
        if full and not history:
            history = [sheet.total]
        sheet.lay(patch, cheaper=full)
        if full:
            history.append(sheet.total)
        report("cutting at full size", number / len(patches))
    return history or [sheet.total]
