"""What is weighed where blocks are chosen, in compiled loops: few and long, as they hold no lock of the interpreter's.

Boxes (b,) of one extent are worked on together. Arrays of their pixels have three axes (`kwatra.pieces.boxes.volume`),
or are flat (b, N); those over the blocks that may be laid in each (b, n) too.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.spanloops import sum_boxes
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
def compare(
    raw: Any, against: Any, hangs: Any, spans: Any, valid: Any, share: Any, scales: Any, steps: Any, found: Any
) -> None:
    """Set what is `found` (b, k, n): of k images the mean squared differences of blocks to what is known of boxes.

    It is in units of their scales (k,), to 1 / steps. raw (b, k, n): the squared differences, less the energy of what
    is known. against (b, k + 1, A, B, C): of each pixel that energy, and whether it is known; where none is nothing
    differs. hangs: whether any block hangs over the image; spans: of each axis the first pixels of boxes that do not
    with a block, and those after the last. What does is taken to differ as in that one of the valid (b, n) blocks which
    a share of them are no worse than.
    """
    squares = np.empty(found.shape[2])
    for box in range(len(found)):
        count, inside = against[box, -1].sum(), np.empty((found.shape[1] + 1, len(squares)))
        if hangs:
            inside = sum_boxes(against[box], spans[0], spans[1]).reshape(inside.shape)
        for image in range(found.shape[1]):
            energy = against[box, image].sum()
            for i in range(len(squares)):
                squares[i] = max(raw[box, image, i] + energy, 0.0)
            if hangs:
                _take_fairly(squares, energy, count, inside[image], inside[-1], valid[box], share)
            for i in range(len(squares)):
                mean = squares[i] / (count * scales[image]) if count > 0 else 0.0
                found[box, image, i] = np.rint(mean * steps) / steps


@jitted
def _take_fairly(squares: Any, energy: Any, count: Any, seen: Any, inside: Any, valid: Any, share: Any) -> None:
    """Have what hangs over differ fairly; seen (n,): the energy of what does not; inside (n,): of how many pixels."""
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
def attain(mismatches: Any, valid: Any, same: Any, good: Any, floor: Any) -> Any:
    """The disagreement that a texture affords, given that of all blocks (n,): what others are measured by.

    It is the geometric mean of the least, and of what a good share stay below; neither counts less than `floor`. Of
    blocks that are valid and do not merely continue what is there (`same` is 0), or else of all valid ones.
    """
    every, blocks = np.empty(len(mismatches)), 0
    for fresh in (True, False):
        for i in range(len(every)):
            if valid[i] and (same[i] == 0 or not fresh):
                every[blocks] = mismatches[i]
                blocks += 1
        if blocks > 0:
            break
    some = every[:blocks]
    return np.sqrt(max(some.min(), floor) * max(quantile(some, good), floor))


@jitted
def weigh(
    found: Any, valid: Any, same: Any, some: Any, good: Any, floor: Any, gaps: Any, away: Any, worn: Any, near: Any,
    pixels: Any, again: Any, beside: Any, steps: Any, in_step: Any, costs: Any,
) -> None:  # fmt: skip
    """Set what blocks cost (b, n) in boxes, infinite where they are not `valid` (b, n).

    found (b, k, n): how little they agree in colors, and, if k is 2, in where gaps lie; it is counted in what can be
    attained (`attain`, with `good` and `floor`). gaps: how much these count beside colors, where `some` (b,) is known.
    away (b, n) or (b, 0): what places charge. worn, near, same, pixels, again, beside: as of `charge_shown`. steps
    (b, n) or (b, 0): what they cost out of a lattice's step; in_step: what does at most that is in step.
    """
    shown, cost = np.empty(found.shape[2]), np.empty(found.shape[2])
    for box in range(len(found)):
        afforded = attain(found[box, 0], valid[box], same[box], good, floor)
        for i in range(len(cost)):
            charge = away[box, i] if away.shape[1] > 0 else 0.0
            cost[i] = (found[box, 0, i] + charge) / afforded
        if found.shape[1] > 1 and some[box]:
            afforded = attain(found[box, 1], valid[box], same[box], good, floor)
            for i in range(len(cost)):
                cost[i] = (cost[i] + gaps * (found[box, 1, i] / afforded)) / (1 + gaps)
        charge_shown(worn, near[box], same[box], pixels, again, beside, shown)
        if steps.shape[1] > 0 and some[box]:
            keep_in_step(steps[box], in_step, valid[box], shown)
        for i in range(len(cost)):
            costs[box, i] = cost[i] + shown[i] if valid[box, i] else np.inf


@jitted
def charge_shown(worn: Any, near: Any, same: Any, pixels: Any, again: Any, beside: Any, cost: Any) -> None:
    """Set what blocks cost (n,) for what was shown before.

    worn (n,): what they cost for how often their pixels were. near (n,): the sums of how near to the box these are
    shown; (0,): nowhere is asked. same (n,): how many pixels only continue a copy; pixels (n,): how many there are.
    again, beside: what a block costs that continues a copy, that is shown right beside.
    """
    for i in range(len(worn)):
        cost[i] = worn[i]
        if len(near) > 0:
            cost[i] += beside / pixels[i] * (near[i] - same[i])
        if same[i] > 0:
            cost[i] += again


@jitted
def keep_in_step(step: Any, most: Any, valid: Any, cost: Any) -> None:
    """Add to what blocks cost (n,) for what was shown before what they do for being out of step, `step` (n,).

    What was shown before is no reason to leave the lattice: it counts from the least that it costs among `valid` blocks
    in step, which cost at most so much for that. Of an exemplar of two periods hardly more than one block is, which
    else costs more than one beside it.
    """
    least = np.inf
    for i in range(len(step)):
        if valid[i] and step[i] <= most:
            least = min(least, cost[i])
    for i in range(len(step)):
        cost[i] = step[i] + (cost[i] if least == np.inf else max(cost[i] - least, 0.0))


@jitted
def cover(needed: Any, known: Any, corners: Any, sizes: Any, valid: Any, covering: Any) -> None:
    """Set which `valid` (A, B, C) blocks are `covering` (b, A, B, C) all pixels of boxes that are needed but not known.

    needed, known (b, *E): of the boxes, of three axes. corners: axis by axis where blocks start; sizes (3,): the
    exemplar's, inside of which those pixels have to lie.
    """
    for box in range(len(needed)):
        first, last = np.full(3, 2**62), np.full(3, -1)
        for i in range(needed.shape[1]):
            for j in range(needed.shape[2]):
                for k in range(needed.shape[3]):
                    if needed[box, i, j, k] and not known[box, i, j, k]:
                        for axis, at in enumerate((i, j, k)):
                            first[axis], last[axis] = min(first[axis], at), max(last[axis], at)
        some = last[0] >= 0
        for i, plane in enumerate(corners[0]):
            there = not some or (plane + first[0] >= 0 and plane + last[0] < sizes[0])
            for j, row in enumerate(corners[1]):
                beside = there and (not some or (row + first[1] >= 0 and row + last[1] < sizes[1]))
                for k, column in enumerate(corners[2]):
                    inside = beside and (not some or (column + first[2] >= 0 and column + last[2] < sizes[2]))
                    covering[box, i, j, k] = inside and valid[i, j, k]


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
def sum_near(places: Any, label: Any, starts: Any, stops: Any, reach: Any, cell: Any, spans: Any, near: Any) -> None:
    """Set the sums (b, n) over blocks of how near to a box each place is shown: 1 in it, 0 from `reach` away.

    places, label (H, W): what pixels show of a mosaic's `cell` (2,), and of which patch, < 0 of none. starts, stops
    (b, 2): of the boxes. spans: of each of three axes the first places under blocks, and those after the last.
    """
    for box in range(len(starts)):
        start, stop, shown = starts[box], stops[box], np.zeros((1, 1, cell[0], cell[1]))
        low, left = max(start[0] - reach, 0), max(start[1] - reach, 0)
        high, right = min(stop[0] + reach, len(places)), min(stop[1] + reach, places.shape[1])
        around = places[low:high, left:right], label[low:high, left:right]
        _sum_near(around[0], around[1], low, left, start, stop, reach, shown.reshape(-1))
        near[box] = sum_boxes(shown, spans[0], spans[1]).reshape(-1)


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
def pick_each(costs: Any, most: Any, acceptable: Any, tolerance: Any, luck: Any, picked: Any) -> None:
    """Set the numbers of the blocks that are picked (b, m) for boxes, given all costs (b, n); -1 where there are fewer.

    They are at most so many (b,), of costs that exceed the least by an acceptable amount (`pick`); where it is one, one
    is drawn within a tolerance, as luck (b,) has it (`draw`).
    """
    picked[:] = -1
    for box in range(len(costs)):
        if most[box] == 1:
            picked[box, 0] = draw(costs[box], tolerance, luck[box])
        else:
            some = pick(costs[box], most[box], acceptable)
            picked[box, : len(some)] = some


@jitted
def draw(costs: Any, reach: Any, luck: Any) -> Any:
    """The number of a block whose cost (n,) is within `reach` of the least; luck, 0 to 1, says of which."""
    most, count = costs.min() + reach, 0
    for cost in costs:
        count += cost <= most
    left = int(luck * count)
    for i in range(len(costs)):
        if costs[i] <= most:
            if left == 0:
                break
            left -= 1
    return i


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
