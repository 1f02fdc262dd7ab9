"""Parts of a picture grow together where what lies between them is weak."""

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

import numpy as np

from kwatra.elements.parting import Array, touching


def merged(parts: Array, strength: Array, least: float, speck: float = 0, spared: Sequence[int] = ()) -> Array:
    """Parts (H, W), numbered from 1, merged until each border between two is at least so strong; 0 is no part.

    The two with the weakest border become one, again and again (Haris et al. 1998, "Hybrid image segmentation using
    watersheds and fast region merging"). A border is as strong as the mean of strength (H, W) along it, of two pixels
    that meet that of the stronger: one with gaps may be strong on the whole. What is smaller than a speck, in pixels,
    is merged across its weakest border, however strong; but not the parts, by number, that are spared.
    """
    count = int(parts.max()) + 1
    beside = _borders(parts, strength, count)
    weakest = [(_mean(b), i, j, b) for i, near in enumerate(beside) for j, b in near.items() if i < j]
    heapify(weakest)
    into, area = np.arange(count), np.bincount(parts.ravel()).tolist()
    for part in spared:
        area[part] = np.inf
    while weakest:
        strong, kept, gone, border = heappop(weakest)
        parted = strong >= least and min(area[kept], area[gone]) >= speck
        if parted or beside[kept].get(gone) is not border:  # which has grown, or is gone
            continue
        into[gone] = kept
        area[kept] += area[gone]
        del beside[kept][gone], beside[gone][kept]
        for other, more in beside[gone].items():
            del beside[other][gone]
            total, pixels = beside[kept].get(other, (0.0, 0))
            longer = total + more[0], pixels + more[1]
            beside[kept][other] = beside[other][kept] = longer
            heappush(weakest, (_mean(longer), kept, other, longer))
        beside[gone] = {}
    while (further := into[into] != into).any():
        into[further] = into[into[further]]
    found: Array = into[parts]
    return found


_Border = tuple[float, int]
"""The sum of strength along it, and its length in pixels."""


def _mean(border: _Border) -> float:
    return border[0] / border[1]


def _borders(parts: Array, strength: Array, count: int) -> list[dict[int, _Border]]:
    """For each part the border with each that it meets."""
    pairs, strong = [], []
    for index, before, meet in touching(parts):
        one, other = parts[index][meet].astype(np.int64), parts[before][meet]
        pairs.append(np.minimum(one, other) * count + np.maximum(one, other))
        strong.append(np.maximum(strength[index], strength[before])[meet])
    found, number = np.unique(np.concatenate(pairs), return_inverse=True)
    total, pixels = np.bincount(number, np.concatenate(strong)), np.bincount(number)
    beside: list[dict[int, _Border]] = [{} for _ in range(count)]
    for pair, border in zip(found.tolist(), zip(total.tolist(), pixels.tolist(), strict=True), strict=True):
        low, high = divmod(pair, count)
        beside[low][high] = beside[high][low] = border
    return beside
