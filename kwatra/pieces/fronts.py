"""Which of many boxes can be worked on at once: those that lie apart; and which together: those of one extent."""

from collections.abc import Sequence

import numpy as np

from kwatra.pieces.boxes import Box


def fronts(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> list[list[int]]:
    """Groups of boxes, by number, to be worked on one group after the other.

    Each box comes in the first group after those of all earlier boxes that lie less than `reach` from it along every
    axis: so none meets another way what was there before it. shape, periodic: of the grid, and which axes wrap.
    """
    starts, stops = (np.array([getattr(box, side) for box in boxes]) for side in ("start", "stop"))
    group = np.zeros(len(boxes), np.int64)
    for number in range(1, len(boxes)):
        near = np.ones(number, bool)
        for axis, (size, wraps) in enumerate(zip(shape, periodic, strict=True)):
            behind, ahead = starts[:number, axis] - stops[number, axis], starts[number, axis] - stops[:number, axis]
            away = np.maximum(behind, ahead)
            if wraps:
                turns = (np.maximum(behind + turn, ahead - turn) for turn in (-size, size))
                away = np.minimum(away, np.minimum(*turns))
            near &= away < reach
        group[number] = group[:number][near].max(initial=-1) + 1
    order = np.argsort(group, kind="stable")
    return [part.tolist() for part in np.split(order, np.flatnonzero(np.diff(group[order])) + 1)]


def alike(boxes: Sequence[Box], most: int) -> list[Sequence[int]]:
    """Groups of boxes, by number, of one extent, at most so many in each."""
    found = dict[tuple[int, ...], list[int]]()
    for number, box in enumerate(boxes):
        found.setdefault(box.extent, []).append(number)
    return [numbers[first : first + most] for numbers in found.values() for first in range(0, len(numbers), most)]
