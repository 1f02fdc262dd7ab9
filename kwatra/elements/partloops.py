"""Parts of pixels that hang together, how large they are, and what of ground they make, in compiled loops.

This module is compiled by numba when first used, so it is imported where parts are looked for.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.regionloops import join


@jitted
def part(pixels: Any, corners: bool, first: Any, area: Any) -> None:
    """Set the first pixel, by number, of the part that each of some pixels (H, W) is of, -1 of others, and areas.

    corners: whether pixels hang together that meet at one alone. area (H * W): of the part that begins at a pixel, 0
    where none does.
    """
    height, width = pixels.shape
    for i in range(height):
        for j in range(width):
            pixel = i * width + j
            area[pixel] = 0
            if not pixels[i, j]:
                first[pixel] = -1
                continue
            left = j > 0 and pixels[i, j - 1]
            above = i > 0 and pixels[i - 1, j]
            before = i > 0 and j > 0 and pixels[i - 1, j - 1]
            behind = i > 0 and j + 1 < width and pixels[i - 1, j + 1]
            first[pixel] = first[pixel - 1] if left else pixel
            # what is beside it hangs together with what is above that
            if above and not (left and (before or corners)):
                join(first, pixel, pixel - width)
            elif corners and not above:
                if before and not left:
                    join(first, pixel, pixel - width - 1)
                if behind:
                    join(first, pixel, pixel - width + 1)
    for pixel in range(height * width):
        if first[pixel] >= 0:
            first[pixel] = first[first[pixel]]  # of an earlier pixel it is known by now
            area[first[pixel]] += 1


@jitted
def clean(split: Any, owner: Any, hole: float, speck: float, small: float, large: float, ground: Any) -> Any:
    """Set the ground (H, W) that a split of pixels makes, without parts less than hole, with others less than speck.

    owner (H, W): the image to which each pixel belongs, -1 for nobody. Returns how much of the split is the largest
    part of some image, 0 to 1, how many of the parts that are no ground have areas between small and large, what these
    cover, and what those from large on do.
    """
    first, area = np.empty(split.size, np.int32), np.empty(split.size, np.int32)
    part(split, True, first, area)
    pixels, owners, kept = split.ravel(), owner.ravel(), ground.ravel()
    image, largest = np.zeros(split.size, owner.dtype), np.zeros(max(owner.max() + 1, 1), np.int64)
    total = 0
    for pixel in range(split.size):
        kept[pixel] = pixels[pixel] and area[first[pixel]] >= hole
        total += pixels[pixel]
        if pixels[pixel]:
            image[first[pixel]] = owners[pixel]
    for pixel in range(split.size):
        largest[image[pixel]] = max(largest[image[pixel]], area[pixel])
    joined = largest.sum() / max(total, 1)
    part((owner >= 0) & ~ground, False, first, area)
    like = cover = merged = 0
    for pixel in range(split.size):
        if first[pixel] >= 0 and area[first[pixel]] < speck:
            kept[pixel] = True
        if small < area[pixel] < large:
            like, cover = like + 1, cover + area[pixel]
        elif area[pixel] >= large:
            merged += area[pixel]
    return joined, like, cover, merged
