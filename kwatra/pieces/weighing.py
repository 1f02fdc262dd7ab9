"""What is weighed where blocks are chosen, in compiled loops: few and long, as they hold no lock of the interpreter's.

Boxes (b,) of one extent are worked on together. Arrays of their pixels have three axes (`kwatra.pieces.boxes.volume`),
or are flat (b, N); those over the blocks that may be laid in each (b, n) too.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.pieces.loops import quantile


@jitted
def take_known(planes: Any, images: Any, places: Any, known: Any, ones: Any, against: Any) -> None:
    """Set what is known of boxes: values of planes (C, M) at their places (b, N), 0 elsewhere, and where that is.

    images (C,): the number of the image that a plane is of. ones (b, C + 1, N): the values, last 1 where known; against
    (b, images + 1, N): the sum of their squares of each image, last the same 1.
    """
    against[:] = 0
    for box in range(len(places)):
        for pixel in range(places.shape[1]):
            there = known[box, pixel]
            for plane in range(len(planes)):
                value = planes[plane, places[box, pixel]] if there else np.float32(0)
                ones[box, plane, pixel] = value
                against[box, images[plane], pixel] += np.float64(value) * value
            ones[box, -1, pixel] = against[box, -1, pixel] = there


@jitted
def compare(raw: Any, against: Any, inside: Any, valid: Any, share: Any, scales: Any, steps: Any, found: Any) -> None:
    """Set what is `found` (b, k, n): of k images the mean squared differences of blocks to what is known of boxes.

    It is in units of their scales (k,), to 1 / steps. raw (b, k, n): the squared differences, less the energy of what
    is known. against (b, k + 1, N): of each pixel that energy, and whether it is known; where none is nothing differs.
    inside (b, k + 1, n): the sum of these over pixels that do not hang over the image with a block; (b, k + 1, 0) where
    none hangs over. What does is taken to differ as in that one of the valid (b, n) blocks which a share of them are no
    worse than.
    """
    squares = np.empty(found.shape[2])
    for box in range(len(found)):
        count = against[box, -1].sum()
        for image in range(found.shape[1]):
            energy = against[box, image].sum()
            for i in range(len(squares)):
                squares[i] = max(raw[box, image, i] + energy, 0.0)
            if inside.shape[2] > 0:
                _take_fairly(squares, energy, count, inside[box, image], inside[box, -1], valid[box], share)
            for i in range(len(squares)):
                mean = squares[i] / (count * scales[image]) if count > 0 else 0.0
                found[box, image, i] = np.rint(mean * steps) / steps


@jitted
def _take_fairly(squares: Any, energy: Any, count: Any, seen: Any, inside: Any, valid: Any, share: Any) -> None:
    """Have what hangs over differ fairly; seen (n,): the energy of what does not, inside (n,): how many pixels do not."""
    means, some = np.empty(len(squares)), 0
    for i in range(len(squares)):
        squares[i] = max(squares[i] - (energy - seen[i]), 0.0)  # with nothing, what hangs over was compared
        if valid[i]:
            means[some] = squares[i] / max(inside[i], 1)
            some += 1
    fair = quantile(means[:some], share)
    for i in range(len(squares)):
        squares[i] += (count - inside[i]) * fair


@jitted
def attain(mismatches: Any, valid: Any, same: Any, good: Any, floor: Any, afforded: Any) -> None:
    """Set the disagreement that is `afforded` (b, k) of blocks' (b, k, n), of k images.

    It is the geometric mean of the least, and of what a good share stay below; neither counts less than `floor`. Of
    blocks that are valid (b, n) and continue nothing (`same` is 0), or all valid ones.
    """
    every = np.empty(mismatches.shape[2])
    for box in range(len(mismatches)):
        fresh = False
        for i in range(len(every)):
            fresh = fresh or (valid[box, i] and same[box, i] == 0)
        for image in range(mismatches.shape[1]):
            blocks = 0
            for i in range(len(every)):
                if valid[box, i] and (same[box, i] == 0 or not fresh):
                    every[blocks] = mismatches[box, image, i]
                    blocks += 1
            some = every[:blocks]
            afforded[box, image] = np.sqrt(max(some.min(), floor) * max(quantile(some, good), floor))


@jitted
def count_offsets(
    places: Any, known: Any, extent: Any, cell: Any, hang: Any, grain: Any, shape: Any, counts: Any
) -> None:
    """Count from which corners (b, n) of an exemplar the known pixels of boxes come, those from elsewhere left out.

    places (b, N): of a mosaic of the exemplar alone, cells of `cell` (axes,); known (b, N): whether there is one;
    extent, shape (axes,): of the boxes, and of the corners. A corner's number is its place and what may `hang` over, in
    steps of grain; it is found once for what goes on along the last axis.
    """
    for box in range(len(places)):
        _count_offsets(places[box], known[box], extent, cell, hang, grain, shape, counts[box])


@jitted
def _count_offsets(
    places: Any, known: Any, extent: Any, cell: Any, hang: Any, grain: Any, shape: Any, counts: Any
) -> None:
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
def charge_shown(worn: Any, near: Any, same: Any, pixels: Any, again: Any, beside: Any, cost: Any) -> None:
    """Set what blocks cost (b, n) for what was shown before.

    worn (n,): what they cost for how often their pixels were. near (b, n): the sums of how near to the box these are
    shown; (b, 0): nowhere is asked. same (b, n): how many pixels only continue a copy; pixels (n,): how many there are.
    again, beside: what a block costs that continues a copy, that is shown right beside.
    """
    for box in range(len(cost)):
        for i in range(len(worn)):
            cost[box, i] = worn[i]
            if near.shape[1] > 0:
                cost[box, i] += beside / pixels[i] * (near[box, i] - same[box, i])
            if same[box, i] > 0:
                cost[box, i] += again


@jitted
def sum_near(places: Any, label: Any, starts: Any, stops: Any, reach: Any, shown: Any) -> None:
    """Add to what is `shown` (b, M) of each place how near to a box it is shown: 1 in it, 0 from `reach` away.

    places, label (H, W): what pixels show, and of which patch, < 0 of none. starts, stops (b, 2): of the boxes.
    """
    for box in range(len(starts)):
        start, stop = starts[box], stops[box]
        low, left = max(start[0] - reach, 0), max(start[1] - reach, 0)
        high, right = min(stop[0] + reach, len(places)), min(stop[1] + reach, places.shape[1])
        around = places[low:high, left:right], label[low:high, left:right]
        _sum_near(around[0], around[1], low, left, start, stop, reach, shown[box])


@jitted
def _sum_near(places: Any, label: Any, top: Any, left: Any, start: Any, stop: Any, reach: Any, shown: Any) -> None:
    """The same of one box and what lies around it, whose first pixel is (top, left).

    How near the pixels of a row are is the same for all rows that are so far up or down.
    """
    share, known = np.zeros(places.shape[1]), -1
    for i in range(places.shape[0]):
        down = max(start[0] - (top + i), top + i - (stop[0] - 1), 0)
        if down != known:
            known = down
            for j in range(places.shape[1]):
                right = max(start[1] - (left + j), left + j - (stop[1] - 1), 0)
                share[j] = max(1 - np.sqrt(down * down + right * right) / reach, 0)
        for j in range(places.shape[1]):
            if label[i, j] >= 0:
                shown[places[i, j]] += share[j]


@jitted
def draw(costs: Any, reach: Any, luck: Any) -> Any:
    """The number (1,) of a block whose cost (n,) is within `reach` of the least; luck, 0 to 1, says of which."""
    most, count = costs.min() + reach, 0
    for cost in costs:
        count += cost <= most
    left = int(luck * count)
    for i in range(len(costs)):
        if costs[i] <= most:
            if left == 0:
                break
            left -= 1
    return np.array([i])


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
