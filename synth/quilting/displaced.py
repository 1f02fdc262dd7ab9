"""Random offsets in time (thesis section 3.5 B), tried out on small frames.

The clip is laid down again and again, displaced in time only, each time cut within all of its frames. Which
displacements make good seams shows on small frames as well as on large ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from torch import Tensor

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting.growth import Report
from synth.quilting.starts import cheapest_start, lay_all
from synth.quilting.synthesis import QuiltSettings, error_region, new_placer, run
from synth.quilting.transition import MOST_PIXELS, shrunk

SMALL = 64
"""Side, in pixels, of the frames on which sequences are tried."""
LASTING = 8
"""Frames that an error-region lasts at least, where the clip is twice as long."""


def lasting_region(shape: Sequence[int], part: float) -> tuple[int, ...]:
    """The error-region's extent for a clip of `shape` (T, H, W).

    Half of it is filled already when a patch is laid there: over fewer frames the patches could not change places
    gradually, and the picture would flash.
    """
    extent = error_region(shape, part)
    return (max(extent[0], min(LASTING, shape[0])), *extent[1:])


def flash(sheet: Sheet[Mosaic]) -> int:
    """What the seams between a frame and the next cost, where it is most."""
    return int(sheet.seams[0].sum((1, 2), dtype=np.int64).max())


def displaced(
    clip: Tensor, begun: Callable[[Tensor], Sheet[Mosaic]], settings: QuiltSettings, report: Report
) -> tuple[Sheet[Mosaic], list[int], str]:
    """The sheet that `begun` makes for a clip (C, T, H, W), filled; its total after each refinement, why that ended.

    No patch has many more than MOST_PIXELS pixels, which bounds the memory of a cut.
    """
    small = shrunk(clip, SMALL)
    area = small.shape[2] * small.shape[3]
    longest = max(MOST_PIXELS // (clip.shape[2] * clip.shape[3]), 4)
    region = (min(lasting_region(clip.shape[1:], settings.region)[0], longest // 2), *small.shape[2:])

    def sew(sheet: Sheet[Mosaic], own: QuiltSettings) -> str:
        placer = new_placer(sheet, own, region, most=longest * area, reach=2.0)
        return run(sheet, placer, own, report)[1]

    patches, stopped = cheapest_start(lambda: begun(small), sew, settings, flash)
    height, width = clip.shape[2:]
    whole = [
        Patch(p.number, (p.shift[0], 0, 0), Box((p.box.start[0], 0, 0), (p.box.extent[0], height, width)))
        for p in patches
    ]
    sheet = begun(clip)
    return sheet, lay_all(sheet, whole, report), stopped
