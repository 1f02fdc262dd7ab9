"""Where blocks start in the output: evenly spread, and overlapping by so much or more.

Blocks of a texture that runs along an axis are long and narrow. Were all of a row of them to end side by side, their
ends would be seen as one line across, so each starts elsewhere than those beside it, as bricks do in a wall. So it is
of scenes that are made larger, of which blocks from different places agree little.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, product

import numpy as np

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array

GOLDEN = (math.sqrt(5) - 1) / 2
"""By this part of a step each line of blocks starts later than the one before: no few lines are then in step."""


OVERLAP = 0.25
"""The part of a block that lies on those before it: within it the seam is free to run. Eight photographs score .051
with it and with .15, which lays as many blocks, and .058 with .35, which lays more."""


@dataclass(frozen=True)
class Spread:
    """Blocks (block, in pixels) on a grain: their `corners`, first pixels, in the order in which they are laid.

    strides: axis by axis the farthest from a block's start to the next. first, last: where those start that follow
    none, and that none follows. backwards: the axes along which they are laid from the last to the first.
    """

    block: tuple[int, ...]
    grain: tuple[int, ...]
    corners: list[tuple[int, ...]]
    strides: tuple[int, ...]
    first: list[set[int]]
    last: list[set[int]]
    backwards: tuple[int, ...] = ()

    @classmethod
    def over(
        cls,
        shape: Sequence[int],
        block: tuple[int, ...],
        overlap: Sequence[int],
        grain: tuple[int, ...],
        wraps: Sequence[bool],
        along: int | None = None,
    ) -> "Spread":
        """Those over an output (*shape), row by row.

        along: the axis along which lines of them are out of step that lie beside each other in a frame.
        """
        axes = list(zip(shape, block, overlap, grain, wraps, strict=True))
        lines = [[_line(*axis, 0.0)] for axis in axes]
        corners = [*product(*(line for (line,) in lines))]
        if along is not None:
            aside = max(axis for axis in range(len(axes)) if axis != along)
            (beside,) = lines[aside]
            lines[along] = [_line(*axes[along], number * GOLDEN % 1) for number in range(len(beside))]
            corners = []
            for line, at in zip(lines[along], beside, strict=True):
                own = {along: line, aside: [at]}
                corners += product(*(own.get(axis, some[0]) for axis, some in enumerate(lines)))
            corners.sort()
        strides = (
            max(chain.from_iterable(map(np.diff, some)), default=b) for some, b in zip(lines, block, strict=True)
        )
        first, last = ([{line[end] for line in some} for some in lines] for end in (0, -1))
        return cls(block, grain, corners, tuple(map(int, strides)), first, last)

    def needed(self, boxes: Sequence[Box], hang: Sequence[int]) -> Array:
        """Which pixels of boxes of one extent (b, *E) a block that hangs over so far has to fill, if they are empty.

        It may hang over towards later blocks, by half of that, so that something is known under those.
        """
        needed = np.ones((len(boxes), *boxes[0].extent), bool)
        for axis, far in enumerate(hang):
            back, size = axis in self.backwards, boxes[0].extent[axis]
            ends, later = (self.first, slice(far // 2)) if back else (self.last, slice(size - far // 2, size))
            followed = [box.start[axis] not in ends[axis] for box in boxes]
            needed.swapaxes(1, axis + 1)[followed, later] = False
        return needed

    def overhang(self, needed: Sequence[int]) -> tuple[int, ...]:
        """How far blocks may hang over, axis by axis: by what they overlap each other, less what is needed of that."""
        sides = zip(self.block, self.strides, needed, self.grain, strict=True)
        return tuple(max(b - stride - least, 0) // g * g for b, stride, least, g in sides)

    def around(self, region: Box, shape: Sequence[int], wraps: Sequence[bool]) -> tuple[int, ...]:
        """Where a block starts, on the grain, that has a region of an output in its middle, as near as it can be."""
        corner = []
        for start, extent, block, size, g, closed in zip(
            region.start, region.extent, self.block, shape, self.grain, wraps, strict=True
        ):
            first = round((start - (block - extent) / 2) / g) * g
            corner.append(first if closed else min(max(first, 0), max(size - block, 0) // g * g))
        return tuple(corner)


def _line(size: int, block: int, overlap: int, grain: int, periodic: bool, phase: float) -> list[int]:
    """Where blocks start along one axis, all but the first and the last a part of a step later.

    Where it is periodic there is neither.
    """
    stride = max(block - overlap, 1)
    if periodic:
        count = -(-size // stride)
        line = {round((i + phase) * size / count / grain) * grain for i in range(count)}
        return sorted({start % size for start in line})
    count = max(-(-(size - block) // stride), 0) + 1
    step = (size - block) / max(count - 1, 1)
    line = {math.ceil(min((i + phase) * step, size - block) / grain) * grain for i in range(count)}
    return sorted(start for start in {0, *line} if start < size)


def overlap_of(block: Sequence[int]) -> tuple[int, ...]:
    """By how much blocks of some size overlap."""
    return tuple(max(round(b * OVERLAP), 1) for b in block)
