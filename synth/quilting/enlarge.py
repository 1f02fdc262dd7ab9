"""Larger frames than the clip's (thesis section 3.5 E), and one quilt made from another.

Copies that last as long as the clip and are moved in the frame keep every motion whole from first frame to last. They
stand side by side from border to border, so that a scene's ground stays at the bottom and its sky at the top, each a
few frames ahead of or behind its neighbors, so that what is seen twice is not seen moving twice. The seams between them
are surfaces along time, which show as lines that stand still: motion does not hide them, so they are cut by the plain
cost and splined unless no blending is wanted. What comes out is a clip of its own, to be looped or lengthened like any
other; `composed` then says where in the original each pixel is from.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Sheet
from synth.quilting.blendseams import ending_reach
from synth.quilting.growth import Report, fill
from synth.quilting.starts import cheapest_start, lay_all
from synth.quilting.synthesis import (
    Quilt,
    QuiltSettings,
    new_placer,
    new_sheet,
    result_of,
    sources_of,
)
from synth.quilting.transition import MOST_PIXELS

FRAMES = 16
"""About how many of the frames patches are chosen on."""
SIDE = 40
"""The least side, in pixels, of those frames, however small they are made."""
SMALLER = 4
"""How many times smaller the frames are on which patches are chosen, at most: time shrinks with its square."""
SPARE = 5
"""One frame in so many is given up, so that copies beside each other need not move in step."""


def enlarged(clip: Tensor, size: Sequence[int], settings: QuiltSettings, report: Report) -> Quilt:
    """The clip (C, T, H, W) with frames of another size, about T - T / SPARE of them.

    Patches are chosen on few and small frames, by matching all that they overlap: it is most of a frame, and seams
    there last the whole clip. No patch has many more than MOST_PIXELS pixels, which bounds the memory of a cut.
    """
    blended = bool(settings.feather) or settings.spline
    settings = dataclasses.replace(settings, placement="whole", normalized=False, feather=0.0, spline=blended)
    count, side = clip.shape[1], min(clip.shape[2:])
    scale = (max(count // FRAMES, 1), *[min(max(side // SIDE, 1), SMALLER)] * 2)
    small = F.avg_pool2d(clip[:, :: scale[0]], scale[1:])
    spare = small.shape[1] // SPARE
    shape = (small.shape[1] - spare, *[-(-n // f) for n, f in zip(size, scale[1:], strict=True)])
    regions = stations(small.shape[1:], shape)
    limits: dict[str, Any] = {
        "most": MOST_PIXELS // math.prod(scale),
        "reach": 2.0,
        "margin": tuple(-(-m // f) for m, f in zip(ending_reach(3, 0.0, blended), scale, strict=True)),
        "inside": True,
        "apart": (max(spare // 3, 1), *small.shape[2:]),
    }

    def sew(sheet: Sheet[Mosaic], own: QuiltSettings) -> str:
        placer = new_placer(sheet, own, regions[0].extent, **limits)
        for region in regions:
            patch = placer.choose(region, filling=True)
            if patch is None:
                placer.used.clear()
                patch = placer.choose(region, filling=True)
            assert patch is not None, "every region is one that a source inside covers"
            sheet.lay(patch)
        fill(sheet, placer, None, report)
        return f"{len(sheet.patches)} copies that last as long as the clip are laid side by side"

    patches, stopped = cheapest_start(lambda: new_sheet(sources_of(small, settings), shape, settings), sew, settings)
    sheet = new_sheet(sources_of(clip, settings), (count - spare * scale[0], *size), settings)
    history = lay_all(sheet, [p.scaled(scale, sheet.shape) for p in patches], report)
    return result_of(sheet, settings, history, stopped)


def stations(source: Sequence[int], shape: Sequence[int]) -> list[Box]:
    """Regions of an output for one copy of the source each: its middle half, or where it ends with the output.

    Copies are spread evenly from border to border, no further apart than half their extent; all of an axis along which
    the source is as long as the output.
    """
    lines = []
    for e, n in zip(source, shape, strict=True):
        steps = max(-(-(n - e) // max(e // 2, 1)), 0)
        if steps == 0:
            lines.append([(0, n)])
            continue
        firsts = [(n - e) * i // steps + (e - e // 2) * i // steps for i in range(steps + 1)]
        lines.append([(first, e // 2) for first in firsts])
    return [Box(tuple(s for s, _ in spans), tuple(e for _, e in spans)) for spans in itertools.product(*lines)]


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
