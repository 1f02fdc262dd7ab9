"""Several starts tried out on a small version of the work, and the best laid at full size.

Which patches make good seams shows on a part of a clip as well as on all of it, at a part of the time: a few sequences
of patches are drawn and refined there, and that with the cheapest seams is laid, in the same order, in the whole.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from synth.quilting.canvas import Canvas, Patch
from synth.quilting.growth import Report
from synth.quilting.synthesis import QuiltSettings

STARTS = 4


def cheapest_start(
    begun: Callable[[], Canvas],
    sew: Callable[[Canvas, QuiltSettings], str],
    settings: QuiltSettings,
    price: Callable[[Canvas], int] = lambda canvas: canvas.total,
) -> tuple[list[Patch], str]:
    """The patches that are seen in the best of the starts on `begun()`, in order, and why it stopped, as `sew` says.

    `sew` lays them. The best is that of the least `price`. The starts differ by seed, and share the time allowed.
    """
    seconds = None if settings.seconds is None else settings.seconds / STARTS
    trials = []
    for start in range(STARTS):
        own = dataclasses.replace(settings, seed=settings.seed * STARTS + start, seconds=seconds)
        canvas = begun()
        known = len(canvas.patches)
        stopped = sew(canvas, own)
        seen = np.unique(canvas.label)
        trials.append((price(canvas), start, [canvas.patches[k] for k in seen[seen >= known]], stopped))
    _, _, patches, stopped = min(trials)
    return patches, stopped


def lay_all(canvas: Canvas, patches: Sequence[Patch], report: Report) -> list[int]:
    """Lay patches in order, once the canvas is full only where they lower the total; that total after each of those."""
    history: list[int] = []
    for number, patch in enumerate(patches):
        full = bool(canvas.filled.all())
        if full and not history:
            history = [canvas.total]
        canvas.lay(patch, cheaper=full)
        if full:
            history.append(canvas.total)
        report("cutting at full size", number / len(patches))
    return history or [canvas.total]
