"""Which of many boxes can be worked on at once: those that lie apart; and which together: those of one extent."""

from collections.abc import Sequence

import numpy as np

from kwatra.pieces.boxes import Box


def fronts(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> list[list[int]]:
    """Groups of boxes, by number, to be worked on one group after the other.

    Each box comes in the first group after those of all earlier boxes that lie less than `reach` from it along every
    axis: so none meets another way what was there before it. shape, periodic: of the grid, and which axes wrap.
    """
    sides = _sides(boxes)
    group = np.zeros(len(boxes), np.int64)
    for number in range(1, len(boxes)):
        near = _near(number, *sides, reach, shape, periodic)
        group[number] = group[:number][near].max(initial=-1) + 1
    order = np.argsort(group, kind="stable")
    return [part.tolist() for part in np.split(order, np.flatnonzero(np.diff(group[order])) + 1)]


def last_apart(boxes: Sequence[Box], reach: int, shape: Sequence[int], periodic: Sequence[bool]) -> bool:
    """Whether the last of boxes could be worked on at once with all others, see `fronts`."""
    return not _near(len(boxes) - 1, *_sides(boxes), reach, shape, periodic).any()


def _sides(boxes: Sequence[Box]) -> tuple[np.ndarray, np.ndarray]:
    """The first pixels of boxes (n, axes), and those after their last."""
    return np.array([box.start for box in boxes]), np.array([box.stop for box in boxes])


def _near(
    number: int, starts: np.ndarray, stops: np.ndarray, reach: int, shape: Sequence[int], periodic: Sequence[bool]
) -> np.ndarray:
    """Which boxes before one lie less than `reach` from it along every axis, (number,)."""
    near = np.ones(number, bool)
    for axis, (size, wraps) in enumerate(zip(shape, periodic, strict=True)):
        behind, ahead = starts[:number, axis] - stops[number, axis], starts[number, axis] - stops[:number, axis]
        away = np.maximum(behind, ahead)
        if wraps:
            turns = (np.maximum(behind + turn, ahead - turn) for turn in (-size, size))
            away = np.minimum(away, np.minimum(*turns))
        near &= away < reach
    return near


def alike(boxes: Sequence[Box], most: int) -> list[Sequence[int]]:
    """Groups of boxes, by number, of one extent, at most so many in each."""
    found = dict[tuple[int, ...], list[int]]()
    for number, box in enumerate(boxes):
        found.setdefault(box.extent, []).append(number)
    return [numbers[first : first + most] for numbers in found.values() for first in range(0, len(numbers), most)]
