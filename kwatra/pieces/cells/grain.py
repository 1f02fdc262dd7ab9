"""Grain of warped elements, which is not warped with them: on a stone that is drawn out it is as round as before.

Within an element detail is read apart from what is smooth (`kwatra.source.read_warped`): not where it is warped to, but
in small blocks, each moved as a whole, as far as its pixels are on the mean. Along outlines all is warped, so that
joints stay whole. Elements that are loose are hardly stretched, and left as they are: rings of coins would part.
"""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.pieces.cells.shapes import Cells
from kwatra.pieces.seams import Array

BLOCK = 8
"""px along a side of what is moved as a whole. By eye, on granite and made stones: with 4 some is still drawn out."""

NEAR, SOFT = 1.0, 1.0
"""Detail is read apart from so many px within an outline on, and all of it as many again further in. By eye; nine made
textures and stones score the same with 2 and 2."""


class Grain(NamedTuple):
    """Where detail is read: places (2, H, W) int64; share (H, W), 0 to 1: how much of it, the rest is warped."""

    places: Array
    share: Array

    @classmethod
    def warped(cls, places: Array) -> "Grain":
        """That of what shows places (2, H, W) all of which is read there."""
        return cls(np.rint(places).astype(np.int64), np.zeros(places.shape[1:], np.float32))


def grain_of(places: Array, copy: Array, warped: Array, cells: Cells) -> Grain:
    """The grain of what shows places (2, H, W) between pixels of copies of cells, numbered (H, W), where it is warped.

    Memory is that of some arrays of the output's size.
    """
    grain = Grain.warped(places)
    pixels, shape = np.argwhere(warped).T, np.array(cells.number.shape)[:, None]
    blocks = np.ravel_multi_index((copy[warped], *(pixels // BLOCK)), (copy.max() + 1, *copy.shape))
    number = np.unique(blocks, return_inverse=True)[1]
    count = np.bincount(number)
    moved = np.stack([np.rint(np.bincount(number, off) / count) for off in places[:, warped] - pixels])
    own, there = grain.places[:, warped], (pixels + moved[:, number].astype(np.int64)).clip(0, shape - 1)
    within = ndimage.distance_transform_edt(np.pad(cells.element, 1))[1:-1, 1:-1]
    least = np.minimum(within[tuple(own)], within[tuple(there)])
    one = cells.number[tuple(own)] == cells.number[tuple(there)]
    grain.share[warped] = np.where(one, np.clip((least - NEAR) / SOFT, 0, 1), 0)
    grain.places[:, warped] = np.where(grain.share[warped] > 0, there, own)
    return grain
