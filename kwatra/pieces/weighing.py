"""What is weighed where a block is chosen, in compiled loops: few and long, as they hold no lock of the interpreter's.

Arrays of pixels have three axes (`kwatra.pieces.boxes.volume`), or are flat (N,); those over blocks (n,) too.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.pieces.loops import quantile


@jitted
def look(label: Any, places: Any, start: Any, shown: Any, known: Any) -> None:
    """Set the places that are `shown` in a box, and which of them are known.

    label, places: of the whole sheet, around which a box may pass; start (3,): of the box.
    """
    n = label.shape
    for i in range(shown.shape[0]):
        for j in range(shown.shape[1]):
            one, other = (start[0] + i) % n[0], (start[1] + j) % n[1]
            for k in range(shown.shape[2]):
                last = (start[2] + k) % n[2]
                shown[i, j, k], known[i, j, k] = places[one, other, last], label[one, other, last] >= 0


@jitted
def take_known(image: Any, places: Any, known: Any, ones: Any, against: Any) -> Any:
    """Set what is known of a box: values of an image (C, M) at its places (N,), 0 elsewhere, and where that is.

    ones (C + 1, N): the values, last 1 where known; against (2, N): their squares' sum and the same 1. Returns the sum
    of the squares.
    """
    channels = len(image)
    for pixel in range(len(known)):
        square = 0.0
        for channel in range(channels):
            value = image[channel, places[pixel]] if known[pixel] else np.float32(0)
            ones[channel, pixel] = value
            square += np.float64(value) * value
        ones[channels, pixel] = against[1, pixel] = known[pixel]
        against[0, pixel] = square
    return against[0].sum()


@jitted
def compare(
    raw: Any, energy: Any, count: Any, inside: Any, valid: Any, share: Any, scale: Any, steps: Any, mismatch: Any
) -> None:
    """Set the mean squared differences (n,) of blocks to `count` known pixels, in units of `scale`, to 1 / steps.

    raw (n,): the squared differences, less the pixels' own `energy`. inside (2, n): the energy of pixels, and how many,
    that do not hang over the image with a block; (2, 0) where none hangs over. What does is taken to differ as in that
    one of the valid (n,) blocks which a share of them are no worse than.
    """
    squares = np.empty(len(mismatch))
    for i in range(len(squares)):
        squares[i] = max(raw[i] + energy, 0.0)
    if inside.shape[1] > 0:
        _take_fairly(squares, energy, count, inside, valid, share)
    for i in range(len(squares)):
        mismatch[i] = np.rint(squares[i] / (count * scale) * steps) / steps


@jitted
def _take_fairly(squares: Any, energy: Any, count: Any, inside: Any, valid: Any, share: Any) -> None:
    means, some = np.empty(len(squares)), 0
    for i in range(len(squares)):
        squares[i] = max(squares[i] - (energy - inside[0, i]), 0.0)  # with nothing, what hangs over was compared
        if valid[i]:
            means[some] = squares[i] / max(inside[1, i], 1)
            some += 1
    fair = quantile(means[:some], share)
    for i in range(len(squares)):
        squares[i] += (count - inside[1, i]) * fair


@jitted
def attain(mismatches: Any, valid: Any, same: Any, good: Any, floor: Any) -> Any:
    """The disagreement (n,) that is afforded: the geometric mean of the least, and of what a good share stay below.

    Neither counts less than `floor`. Of blocks that are valid and continue nothing (`same` is 0), or all valid ones.
    """
    some, blocks = np.empty(len(mismatches)), 0
    for fresh in (True, False):
        for i in range(len(mismatches)):
            if valid[i] and (same[i] == 0 or not fresh):
                some[blocks] = mismatches[i]
                blocks += 1
        if blocks > 0:
            break
    some = some[:blocks]
    return np.sqrt(max(some.min(), floor) * max(quantile(some, good), floor))


@jitted
def count_offsets(
    places: Any, known: Any, extent: Any, cell: Any, hang: Any, grain: Any, shape: Any, counts: Any
) -> None:
    """Count from which corners (n,) of an exemplar the known pixels of a box come, those from elsewhere left out.

    places (N,): of a mosaic of the exemplar alone, cells of `cell` (axes,); known (N,): whether there is one; extent,
    shape (axes,): of the box, and of the corners. A corner's number is its place and what may `hang` over, in steps of
    grain; it is found once for what goes on along the last axis.
    """
    axes = len(extent)
    number, found = 0, False
    for pixel in range(len(places)):
        if not known[pixel]:
            continue
        if pixel % extent[-1] == 0 or not known[pixel - 1] or places[pixel] != places[pixel - 1] + 1:
            there, here, number, stride, found = places[pixel], pixel, 0, 1, True
            for axis in range(axes - 1, -1, -1):
                first = there % cell[axis] - 1 - here % extent[axis] + hang[axis]
                step = first // grain[axis]
                found = found and first >= 0 and step < shape[axis]
                number += step * stride
                stride *= shape[axis]
                there //= cell[axis]
                here //= extent[axis]
        if found:
            counts[number] += 1


@jitted
def charge_shown(
    used: Any, near: Any, same: Any, pixels: Any, mean: Any, usage: Any, again: Any, beside: Any, cost: Any
) -> None:
    """Set what blocks cost (N,) for what was shown before, given the sums of how often and how near their pixels were.

    same: how many pixels only continue a copy; pixels: how many there are. usage, again, beside: what a block costs
    that was used once more than in the mean, that continues a copy, that is shown right beside.
    """
    for i in range(len(used)):
        cost[i] = usage * (used[i] / pixels[i] - mean) + beside / pixels[i] * (near[i] - same[i])
        if same[i] > 0:
            cost[i] += again


@jitted
def sum_near(places: Any, label: Any, corner: Any, start: Any, stop: Any, reach: Any, shown: Any) -> None:
    """Add to each place's `shown` how near to a box it is shown: 1 in it, 0 from `reach` away.

    places, label (H, W): what pixels show, and of which patch, < 0 of none; the first of them lies at `corner`. start,
    stop: of the box. How near the pixels of a row are is the same for all rows that are so far up or down.
    """
    share, known = np.zeros(places.shape[1]), -1
    for i in range(places.shape[0]):
        down = max(start[0] - (corner[0] + i), corner[0] + i - (stop[0] - 1), 0)
        if down != known:
            known = down
            for j in range(places.shape[1]):
                right = max(start[1] - (corner[1] + j), corner[1] + j - (stop[1] - 1), 0)
                share[j] = max(1 - np.sqrt(down * down + right * right) / reach, 0)
        for j in range(places.shape[1]):
            if label[i, j] >= 0:
                shown[places[i, j]] += share[j]


@jitted
def pick(costs: Any, most: Any, reach: Any) -> Any:
    """The numbers of at most so many blocks of the least costs (n,), within `reach` of it, the cheapest first."""
    chosen = np.full(most, -1)
    found = 0
    for i in range(len(costs)):
        if found == most and costs[i] >= costs[chosen[most - 1]]:
            continue
        found = min(found + 1, most)
        at = found - 1
        while at > 0 and costs[chosen[at - 1]] > costs[i]:
            chosen[at] = chosen[at - 1]
            at -= 1
        chosen[at] = i
    last = found
    while last > 1 and costs[chosen[last - 1]] > costs[chosen[0]] + reach:
        last -= 1
    return chosen[:last]
