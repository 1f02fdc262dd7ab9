"""Holes in pictures that run along an axis, as wood and brushed metal do, covered by strips that continue their lines.

Windows that are compared as a whole seldom meet at both ends of a hole: of several lines that end there hardly two go
on together elsewhere. A strip is of a line or two. It is laid where it fits what is known at its end, or was laid
there before; where strips from both ends meet they are cut where the lines differ least, each for itself, since seams
cost less beside lines than across (`synth.texture.sewing`).
"""

import itertools
from collections.abc import Callable

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar, Progress, Result
from kwatra.base import generator_of, nearest_known
from kwatra.elements import STRAIGHT, anisotropy, runs_along
from kwatra.levels import FEWEST
from kwatra.pieces import Box
from kwatra.source import sourcemap
from synth.texture.sewing import Sewing

LENGTH, WIDTH = 32, 4
"""Size of strips along the lines and across, in pixels. In two woods and brushed metal made in code the steepest rows
of six holes are 1.6, 3.6 and 4.6 times as steep as usual there, and 6.4, 13 and 18 times if holes are filled as others
are, as sharply; strips of half the width differ by -.1, -.6, .0 from that, of twice the width by .1, 1.7 and 1.6, of
24 pixels by -.2, -.5, -.1 and of 48 by .3, .3, .4. Others of their kind, not tuned on: 1.6, 3.3, 4.7 in place of 6.8,
10, 17."""

TURNS = 2
"""How often strips are laid, the first time included; with 5 those rows differ by less than .1."""

NEAR = 256
"""Strips are sought on so many pixels about where they are laid: a bound on time and memory, not tuned."""


def strips_along(source: Exemplar) -> int | None:
    """The axis along which strips of a source can be laid, 0 down and 1 to the right; None if it runs along none."""
    along = runs_along(anisotropy(source), STRAIGHT)
    if along is None or int(source.corners(_sides(along)).sum()) < FEWEST:
        return None
    return along


def filled_by_strips(
    known: Tensor, missing: Tensor, source: Exemplar, along: int, seed: int, callback: Callable[[Progress], None] | None
) -> tuple[Result, tuple[slice, ...]]:
    """The part of a picture (C, H, W) about its missing pixels (H, W), filled from a source, and where it lies.

    along: the axis on which strips lie.
    """
    place = missing.nonzero()
    low, high = (place.amin(0) - LENGTH).clamp(min=0).tolist(), (place.amax(0) + 1 + LENGTH).tolist()
    box = tuple(slice(a, min(b, size)) for a, b, size in zip(low, high, missing.shape, strict=True))
    hole = missing[box].numpy()
    picture = _continued(known[(slice(None), *box)], hole, along)
    sewing = Sewing(source, hole.shape, NEAR, picture=picture, first=low)
    sewing.lay_picture(Box((0, 0), hole.shape), must_not=hole)
    sewing.sheet.fixed[~hole] = True

    def report(part: float) -> None:
        if callback is not None:
            callback(Progress(part, 0, 0, float(sewing.sheet.total), picture))

    sewing.sew(_strips(hole, along, seed), TURNS, report)
    blended, where = sewing.blended(), sewing.places.to(source.canvas.device)
    return Result(blended, sourcemap.look_up(source.origin, where), where, [], [], "the seams are closed"), box


def _continued(picture: Tensor, hole: np.ndarray, along: int) -> Tensor:
    """A picture (C, H, W) whose lines go on into its hole (H, W): there seams are compared with what would go on.

    Where nothing of a line is known it is like the line beside it.
    """
    scale = (1.0, max(hole.shape)) if along == 0 else (max(hole.shape), 1.0)
    return picture[(slice(None), *nearest_known(torch.from_numpy(~hole), scale))]


def _strips(hole: np.ndarray, along: int, seed: int) -> list[Box]:
    """Boxes that cover a hole (H, W), half over each other, those at its ends first; they begin anywhere, as drawn."""
    extent = tuple(min(side, size) for side, size in zip(_sides(along), hole.shape, strict=True))
    lines = list[list[int]]()
    generator = generator_of(seed)
    for axis, (side, size) in enumerate(zip(extent, hole.shape, strict=True)):
        there, step = np.flatnonzero(hole.any(1 - axis)), max(side // 2, 1)
        first = int(there[0]) - step - int(torch.randint(step, (), generator=generator))
        starts = (min(max(start, 0), size - side) for start in range(first, int(there[-1]) + 1, step))
        lines.append(list(dict.fromkeys(starts)))
    scale = [1 / side for side in _sides(along)]
    depth, boxes = ndimage.distance_transform_edt(hole, scale), list[tuple[float, Box]]()
    for left, top in itertools.product(lines[1], lines[0]):
        deepest = float(depth[top : top + extent[0], left : left + extent[1]].max())
        if deepest > 0:
            boxes.append((deepest, Box((top, left), extent)))
    return [box for _, box in sorted(boxes, key=lambda each: each[0])]


def _sides(along: int) -> tuple[int, int]:
    """The height and width of a strip."""
    return (LENGTH, WIDTH) if along == 0 else (WIDTH, LENGTH)
