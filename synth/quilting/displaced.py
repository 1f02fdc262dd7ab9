"""Random offsets in time (thesis section 3.5 B), tried out on small frames.

The clip is laid down again and again, displaced in time only, each time cut within all of its frames. Which
displacements make good seams shows on small frames as well as on large ones: a few sequences are drawn and refined
there, and the patches of the one with the cheapest seams are laid, in the same order, at full size.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from torch import Tensor

from synth.quilting.boxes import Box
from synth.quilting.canvas import Canvas, Patch
from synth.quilting.growth import Report
from synth.quilting.synthesis import QuiltSettings, error_region, new_placer, run
from synth.quilting.transition import MOST_PIXELS, shrunk

STARTS = 4
SMALL = 64
"""Side, in pixels, of the frames on which sequences are tried."""


def displaced(
    clip: Tensor, begun: Callable[[Tensor], Canvas], settings: QuiltSettings, report: Report
) -> tuple[Canvas, list[int], str]:
    """The canvas that `begun` makes for a clip (C, T, H, W), filled; its total after each refinement, why that ended.

    No patch has many more than MOST_PIXELS pixels, which bounds the memory of a cut.
    """
    small = shrunk(clip, SMALL)
    area = small.shape[2] * small.shape[3]
    longest = max(MOST_PIXELS // (clip.shape[2] * clip.shape[3]), 4)
    region = (min(error_region(clip.shape[1:], settings.region)[0], longest // 2), *small.shape[2:])
    seconds = None if settings.seconds is None else settings.seconds / STARTS
    trials = []
    for start in range(STARTS):
        own = dataclasses.replace(settings, seed=(settings.seed * STARTS + start) % 2**63, seconds=seconds)
        trial = begun(small)
        known = len(trial.patches)
        _, stopped = run(trial, new_placer(trial, own, region, most=longest * area, reach=2.0), own, report)
        trials.append((trial.total, start, trial.patches[known:], stopped))
    _, _, patches, stopped = min(trials)
    canvas = begun(clip)
    history: list[int] = []
    for number, patch in enumerate(patches):
        full = bool(canvas.filled.all())
        if full and not history:
            history = [canvas.total]
        box = Box((patch.box.start[0], 0, 0), (patch.box.extent[0], *clip.shape[2:]))
        canvas.lay(Patch(patch.number, (patch.shift[0], 0, 0), box), cheaper=full)
        if full:
            history.append(canvas.total)
        report("cutting at full size", number / len(patches))
    return canvas, history or [canvas.total], stopped
