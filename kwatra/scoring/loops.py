"""Windows of videos read one by one, in a compiled loop.

This module is compiled by numba when first used, so it is imported where something is measured.
"""

from typing import Any

from kwatra.base.compiled import Compiled


@Compiled
def read_windows(
    video: Any, places: Any, depth: int, size: int, scale: int, numbers: Any, rows: Any, low: int, high: int
) -> None:
    """Set the rows (n, C * depth * size * size) of these numbers, from low to high, to the windows at places (3, n).

    video (C, T, H, W); places: frame, row and column of the first pixels. Pixels are `scale` apart.
    """
    for i in range(low, high):
        frame, top, left = places[0, i], places[1, i], places[2, i]
        row, at = rows[numbers[i]], 0
        for c in range(video.shape[0]):
            for t in range(depth):
                for j in range(size):
                    line = video[c, frame + t, top + j * scale]
                    for k in range(size):
                        row[at] = line[left + k * scale]
                        at += 1
