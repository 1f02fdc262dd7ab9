"""Larger frames than the clip's (thesis section 3.5 E), and one quilt made from another.

Patches that last as long as the clip and are moved in the frame only keep every motion whole from first frame to last;
the seams between them are surfaces along time, which show as lines that stand still: motion does not hide them, so they
are cut by the plain cost and splined unless no blending is wanted. What comes out is a clip of its own, to be looped or
lengthened like any other; `composed` then says where in the original each pixel is from.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from synth.quilting.boxes import Box
from synth.quilting.canvas import Canvas
from synth.quilting.growth import Report
from synth.quilting.placement import Placer
from synth.quilting.starts import cheapest_start, lay_all
from synth.quilting.synthesis import (
    Quilt,
    QuiltSettings,
    error_region,
    new_canvas,
    new_placer,
    result_of,
    sources_of,
)
from synth.quilting.transition import MOST_PIXELS

FRAMES = 4
"""The frames on which patches are chosen."""
GRID = 4
"""Offsets are multiples of so many pixels: closer ones make the same seams again."""


def enlarged(clip: Tensor, size: Sequence[int], settings: QuiltSettings, report: Report) -> Quilt:
    """The clip (C, T, H, W) with frames of another size, as many as it has.

    Patches are placed by matching all that they overlap: it is most of a frame, and seams there last the whole clip.
    Therefore they are chosen on FRAMES of its frames. No patch has many more than MOST_PIXELS pixels, which bounds the
    memory of a cut.
    """
    blended = bool(settings.feather) or settings.spline
    settings = dataclasses.replace(
        settings, placement="whole", normalized=False, grid=GRID, feather=0.0, spline=blended
    )
    count = clip.shape[1]
    few = clip[:, :: max(count // FRAMES, 1)].contiguous()
    region = (few.shape[1], *error_region(clip.shape[1:], settings.region)[1:])

    def begun(source: Tensor) -> Canvas:
        return new_canvas(sources_of(source, settings), (source.shape[1], *size), settings)

    def placer(canvas: Canvas, own: QuiltSettings) -> Placer:
        return new_placer(canvas, own, region, most=MOST_PIXELS * few.shape[1] // count, reach=2.0)

    patches, stopped = cheapest_start(lambda: begun(few), placer, settings, report)
    canvas = begun(clip)
    lasting = [dataclasses.replace(p, box=Box(p.box.start, (count, *p.box.extent[1:]))) for p in patches]
    return result_of(canvas, settings, lay_all(canvas, lasting, report), stopped)


def composed(outer: Quilt, inner: Quilt) -> Quilt:
    """`outer`, which was made from the image of `inner`, as made from what `inner` was made from.

    Its seams are those of `outer`, and where `outer` has none, those of `inner` that it copied along.
    """
    here = np.indices(outer.patch.shape)
    place = outer.offset.numpy() + here
    at = tuple(place)
    offset = inner.offset.numpy()[(slice(None), *at)] + place - here
    copied = inner.patch.numpy()[at]
    patch = outer.patch.numpy().astype(np.int64) * (int(inner.patch.max()) + 1) + copied
    seams = outer.seams.clone()
    for axis, cost in enumerate(seams):
        inside = inner.seams[axis].numpy()[at]
        patches = outer.patch.numpy()
        same = np.zeros(patches.shape, bool)
        same[tuple(slice(None, -1) if d == axis else slice(None) for d in range(same.ndim))] = (
            np.diff(patches, axis=axis) == 0
        )
        cost += torch.from_numpy(np.where(same, inside, 0))
    _, names = np.unique(patch, return_inverse=True)
    total = float(seams.sum(dtype=torch.float64))
    return dataclasses.replace(
        outer,
        source=torch.from_numpy(inner.source.numpy()[at]),
        offset=torch.from_numpy(offset.astype(np.int32)),
        patch=torch.from_numpy(names.reshape(patch.shape).astype(np.int32)),
        seams=seams,
        cost=total,
        history=tuple(before + total - outer.cost for before in outer.history),
    )
