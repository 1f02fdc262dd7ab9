"""Regions of a picture: pixels that are joined with the next ones below and on the right, and those with theirs."""

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]


def joined(down: Array, right: Array) -> tuple[int, Array]:
    """How many regions there are, and the number of each pixel's (H, W), from 0 in the order of their first pixels.

    down (H - 1, W), right (H, W - 1): whether a pixel is joined with the next one.
    """
    from kwatra.base.regionloops import number_regions

    number = np.empty((len(right), down.shape[1]), np.int64)
    return number_regions(np.ascontiguousarray(down), np.ascontiguousarray(right), number), number
