"""Which blocks of a frame are to be renewed: those most worn, and all that have lost their texture."""

import math

import numpy as np
from torch import Tensor

from kwatra.base import box_sums

_LEAST = 0.005
"""Blocks with less wear than this, on average, are left as they are: a bound on time."""

_AGAIN = 1.25
"""A block is tried again when it is worn so many times as much as a try left it: in a picture the same would be found
again. After 50 frames in which nuts turn by 2 px, motion is off by .132 px and frames flicker by .056, with 7.7 blocks
tried in each; by .154 and .067 without this, with 14; by .127 and .065 with 1.6, with 4. Of the exemplar's sharpness
.99, .96 and 1.00 is left."""

_BETWEEN = 4
"""Blocks start at multiples of this many px, or closer where they are small, and flush with the frame's borders: a
bound on time."""

_APART = 3 / 8
"""Of blocks closer than this, in their sizes, one is renewed in a frame. Not tuned."""


def neediest(
    wear: Tensor, lost: Tensor, left: Tensor | None, sides: tuple[int, int], most: int
) -> list[tuple[int, int]]:
    """Corners (row, column) of up to `most` blocks of `sides` px, and of as many more as hold what is lost.

    wear (H, W): what can be gained; lost (H, W): where there is no texture any more; left (H, W): what tries left, on
    average over their blocks, 0 where there was none; None where nothing was tried.
    """
    rows, columns = (starts(*line) for line in zip(wear.shape, sides, strict=True))
    worn, holes, rested = (
        0 if v is None else box_sums(v.double().numpy(), sides)[np.ix_(rows, columns)] for v in (wear, lost, left)
    )
    area = math.prod(sides)
    worn, rested = worn / area, rested / area
    need = np.where(holes > 0.5, 10 + holes, np.where((worn > _LEAST) & (worn > _AGAIN * rested), worn, 0))
    places: list[tuple[int, int]] = []
    while need.max() > 0:
        row, column = np.unravel_index(int(need.argmax()), need.shape)
        if len(places) >= most and need[row, column] < 10:
            break
        places.append((int(rows[row]), int(columns[column])))
        above, beside = np.abs(rows - rows[row]), np.abs(columns - columns[column])
        need[np.ix_(above < _APART * sides[0], beside < _APART * sides[1])] = 0
    return places


def starts(side: int, size: int) -> np.ndarray:
    """Where blocks of `size` px may start along a side of a frame."""
    line = np.arange(0, side - size + 1, min(_BETWEEN, max(size // 2, 1)))
    return line if line[-1] == side - size else np.append(line, side - size)
