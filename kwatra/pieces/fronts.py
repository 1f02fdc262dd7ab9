"""Which of many boxes can be worked on at once: those that lie apart; and which together: those of one extent.

Of a large output whole parts lie apart once its middle is done: threads then need not wait for each other at fronts.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kwatra.pieces.boxes import Box

MANY = 8
"""Blocks are laid outwards where an output is so many times as long as they have to lie apart: smaller ones have the
bits they have row by row. Eight photographs, 640x640, ten seeds, score .0583 outwards, .0588 row by row, each within
.0004. Of 1024x1024 two threads lay bark 1.6 times as fast as one so, 1.4 times row by row, where they wait at each
front."""


class Outwards(NamedTuple):
    """Boxes in the middle along an axis, those before them, the last first, and those behind them."""

    middle: list[Box]
    before: list[Box]
    behind: list[Box]


def fronts(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> list[list[int]]:
    """Groups of boxes, by number, to be worked on one group after the other.

    Each box comes in the first group after those of all earlier boxes that lie less than `reach` from it along every
    axis: so none meets another way what was there before it. shape, periodic: of the grid, and which axes wrap.
    """
    group = _groups(boxes, reach, shape, periodic)
    order = np.argsort(group, kind="stable")
    return [part.tolist() for part in np.split(order, np.flatnonzero(np.diff(group[order])) + 1)]


def outwards(boxes: Sequence[Box], axis: int, reach: int) -> Outwards | None:
    """Boxes by whether they lie in the middle along an axis; None where they reach over less than MANY of `reach`.

    So many do that no box before them lies less than `reach` along the axis from any behind them.
    """
    starts = sorted({box.start[axis] for box in boxes})
    extent, low = max(box.extent[axis] for box in boxes), len(starts) // 2
    high = low
    while low > 0 and high < len(starts) and starts[high] - starts[low - 1] - extent < reach:
        low, high = (low - 1, high) if (high - low) % 2 else (low, high + 1)
    if low == 0 or high == len(starts) or starts[-1] + extent - starts[0] < MANY * reach:
        return None
    before = [box for box in boxes if box.start[axis] < starts[low]]
    behind = [box for box in boxes if box.start[axis] >= starts[high]]
    within = [box for box in boxes if starts[low] <= box.start[axis] < starts[high]]
    return Outwards(within, sorted(before, key=lambda box: -box.start[axis]), behind)


def last_apart(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> bool:
    """Whether the last of boxes could be worked on at once with all others, see `fronts`."""
    return bool(_groups(boxes, reach, shape, periodic)[-1] == 0)


def _groups(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> np.ndarray:
    """The number (n,) of the group that each box comes in."""
    from kwatra.pieces.loops import find_groups

    group, sides = np.zeros(len(boxes), np.int64), ([box.start for box in boxes], [box.stop for box in boxes])
    starts, stops = np.array(sides, np.int64).reshape(2, len(boxes), len(shape))
    find_groups(starts, stops, reach, np.where(periodic, shape, 0), group)
    return group


def alike(boxes: Sequence[Box], most: int) -> list[Sequence[int]]:
    """Groups of boxes, by number, of one extent, at most so many in each."""
    found = dict[tuple[int, ...], list[int]]()
    for number, box in enumerate(boxes):
        found.setdefault(box.extent, []).append(number)
    return [numbers[first : first + most] for numbers in found.values() for first in range(0, len(numbers), most)]
