"""What blocks cost for where in the exemplar they come from: as terms charge, shown nearby, out of step."""

import math
from collections.abc import Sequence

import numpy as np
import torch
from scipy import ndimage

from kwatra.base.spans import of_volume
from kwatra.elements import Lattice, Rows, out_of_step
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing.corners import Corners
from kwatra.pieces.choosing.seen import Around
from kwatra.pieces.seams import Array, Mosaic, each
from kwatra.pieces.sheet import Sheet
from kwatra.terms import PlaceCharge

STEP, IN_STEP = 0.5, 0.04
"""What a block costs more that is out of step with a periodic texture, by more than this part of its shorter vector.

Set on made tiles, of which then hardly any is cut; twice as much joins pieces of brick walls to longer copies. By a
lattice it counts as that is regular, by rows in full: three walls, two pages and three of made letters, 400x400, three
seeds, have .33 pixels of seams out of step by .15 of a row's height among 100 pixels without, .01 with (.11 with .4 of
it), and score .0585 and .0577.
"""

NEAR = 0.3
"""What a block of a still costs more that is shown right beside as well. On eight textures of loose things (rocks,
terrazzo, onyx, paving, nuts, radishes, tomatoes) it leaves a sixth less that is shown twice within 72 pixels, at the
same quality; 0.6 leaves a fifth less and costs quality."""


EVEN, AROUND = 0.16, 5
"""What a pixel of a scene that is made twice as large costs a cut whose place in the frame is shown once more than all
on average, counted over so many pixels across (not tuned) at the resolution at which blocks are laid; of one as large
as its clip nothing, and between and beyond in proportion to what there is more of it.

To charge each pixel for how far it is from its own place instead shows more of the clip's gradients, but what belongs
there is cut in where it does not fit: a waterfall fell over two edges, and smoke lost sharpness. At the clip's own size
copies keep their places without: charged .2, of twice the frames a waterfall scores .068, smoke .080 and fish .068, not
charged .064, .074 and .064."""

LIKE, KINDS = 0.96, 8
"""The same where all places as steep are shown once more than all on average: places are of so many kinds, as many of
each, from those where the clip is calm to those of the steepest gradients.

Seams go where what they part is dark and flat, so that side of a scene made larger spreads. Half as large again smoke
scores .089, fish .074 and a waterfall .074 with it and with scenes that stay by the square of how much larger they are;
.112, .091 and .074 without and with the cube (two seeds each). Of the clip's sharpness .98, .96 and .98 are left, .93,
.93 and .98 without. With .48, and stay in proportion, smoke scores .094 and fish .085. Chosen on these clips."""


def charged(
    places: Sequence[PlaceCharge],
    start: Sequence[int],
    shape: tuple[int, ...],
    grain: Sequence[int],
    device: torch.device,
) -> Array:
    """What places charge for the block at `start` if it is copied from each corner on the grain, (*shape)."""
    if not places:
        return np.zeros(shape)
    there = torch.from_numpy(np.indices(shape).reshape(len(shape), -1).T * np.array(grain))
    here = torch.tensor([list(start)], device=device)
    costs = [place(here, there[None].to(device))[0].cpu() for place in places]
    away: Array = torch.stack(costs).sum(0).double().numpy().reshape(shape)
    return away


class StepCosts:
    """What blocks cost that are copied from corners on the grain, (*shape): 0 in step with what repeats, else to STEP.

    A lattice counts by how regular it is, rows in full. What boxes ask for overlaps: it is found once for spans of
    offsets. To find it for each box took a quarter of the time of a wall of bricks. Memory: four times the corners for
    each span, of which there are about four.

    exactly: whether a pixel out of step is too much, however long the shorter vector.
    """

    def __init__(
        self, repeats: Lattice | Rows, shape: Sequence[int], grain: Sequence[int], exactly: bool = False
    ) -> None:
        self.repeats, self.shape, self.grain = repeats, tuple(shape), tuple(grain)
        self.near = 1.0 if exactly else max(IN_STEP * repeats.shortest, 1.0)
        self.most = STEP * (repeats.regularity if isinstance(repeats, Lattice) else 1.0)
        self.in_step = self.most / 2  # what does not cost more is
        self._spans: dict[tuple[int, ...], Array] = {}

    def at(self, first: Sequence[int]) -> Array:
        """For the first corner's block at an offset, output less exemplar, less that of a copy in step."""
        sides = list(zip(first, self.shape, self.grain, strict=True))
        span = tuple(offset // (n * g) * n * g + offset % g for offset, n, g in sides)
        if span not in self._spans:
            self._spans[span] = self._found(span)
        ends = (n - 1 - offset // g % n for offset, n, g in sides)
        return self._spans[span][each(slice(end, end + n) for end, n in zip(ends, self.shape, strict=True))]

    def _found(self, span: Sequence[int]) -> Array:
        """For offsets on the grain that fall from the last of as many from a first one on as there are corners."""
        sides = list(zip(span, self.shape, self.grain, strict=True))
        last, sizes = [float(offset + (n - 1) * g) for offset, n, g in sides], [2 * n - 1 for n in self.shape]
        rest = out_of_step(self.repeats, last, sizes, [-g for g in self.grain]).numpy()
        cost: Array = self.most * (1 - np.exp(-((rest / self.near) ** 2)))
        return cost


def around(sheet: Sheet[Mosaic], boxes: Sequence[Box], corners: Corners, twins: Array) -> Around:
    """What is shown around boxes of an image's sheet, as far as a block is long; of any sheet around none.

    twins (t, cells): for each place of the mosaic others that show the same (`kwatra.pieces.choosing.twins`), below 0
    where none does.
    """
    sides = np.array([(box.start, box.stop) for box in boxes], np.int64).reshape(len(boxes), 2, len(corners.block))
    flat = len(sheet.places), -1  # as an image's are already
    places, label = sheet.places.reshape(flat), sheet.label.reshape(flat)
    cell, spans = np.array(sheet.sources.cell), of_volume(corners.under)
    return Around(places, label, twins, sides[:, 0], sides[:, 1], max(corners.block), cell, spans)


class SceneUse:
    """What pixels of a scene that is made larger cost cuts for how often their places in the frame are shown.

    clip (C, T, H, W): at the resolution at which blocks are laid; larger: by how much its frames are made, as a part of
    the clip's.
    """

    def __init__(self, clip: Array, larger: float) -> None:
        self.larger = larger
        slopes = [np.abs(np.diff(clip, axis=axis, append=clip.take([-1], axis))).mean((0, 1)) for axis in (2, 3)]
        steep = _around(slopes[0] + slopes[1])
        rank = np.empty(steep.size, np.int64)
        rank[steep.argsort(axis=None, kind="stable")] = np.arange(steep.size)
        self.kind = rank * KINDS // steep.size
        self._sizes = np.maximum(np.bincount(self.kind, minlength=KINDS), 1)

    @classmethod
    def of(cls, clip: Array, shape: Sequence[int]) -> "SceneUse | None":
        """The same for an output (T, H, W); None where that is not larger, so that pixels cost nothing."""
        larger = math.prod(shape[-2:]) / math.prod(clip.shape[-2:]) - 1
        return cls(clip, larger) if larger > 0 else None

    def prices(self, used: Array) -> Array:
        """What each pixel costs (T, H, W), in variances, if pixels are shown so often."""
        often = used.sum(0)
        kinds = np.bincount(self.kind, often.ravel(), KINDS) / self._sizes
        each = EVEN * _around(often) + LIKE * kinds[self.kind].reshape(often.shape)
        return np.broadcast_to(self.larger / max(often.mean(), 1e-12) * each, used.shape)


def _around(values: Array) -> Array:
    """The mean of values (H, W) around each."""
    mean: Array = ndimage.uniform_filter(values, AROUND, mode="nearest")
    return mean
