"""What is known of boxes, and how blocks that may be laid in them compare with it, in compiled loops.

They are called together, by `see` and by `kwatra.pieces.choosing.weighing.weigh`: threads that share blocks then seldom
wait for the interpreter. Boxes (b,) of one extent are worked on together. Arrays of their pixels have three axes
(`kwatra.base.spans.volume`), or are flat (b, N); those over the blocks that may be laid in each (b, n) too.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.spanloops import sum_boxes
from kwatra.pieces.loops import copy_into, quantile
from kwatra.pieces.sheet.pixels import count_most, look


@jitted
def see(
    label: Any, places: Any, starts: Any, extent: Any, needed: Any, patches: Any, corners: Any, planes: Any,
    images: Any, seen: Any,
) -> None:  # fmt: skip
    """Set what is `Seen` of boxes of an extent (axes,) that begin at starts (b, 3), of a sheet's label and places.

    Of these there are three axes, of places one before. needed (b, A, B, C): which pixels a block has to fill if they
    are empty; of no boxes where none. patches: how many there are, 0 if it is not asked of which most pixels are.
    corners: `Frame`; planes, images: as of `take_known`.
    """
    look(label, places, starts, seen.places, seen.known)
    count_most(label, starts, seen.known, patches, seen.most)
    boxes, pixels = len(starts), seen.known[0].size
    there, known = seen.places.reshape((boxes, pixels)), seen.known.reshape((boxes, pixels))
    take_known(planes, images, there, known, seen.ones, seen.against.reshape((boxes, seen.against.shape[1], pixels)))
    count_offsets(there, known, extent, corners, seen.same)
    for box in range(boxes):
        seen.some[box] = known[box].any()
        if len(needed) > 0:
            cover(needed[box], seen.known[box], corners, seen.valid[box])
        else:
            copy_into(corners.valid.ravel(), seen.valid[box])


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
def compare(compared: Any, valid: Any, found: Any) -> None:
    """Set what is `found` (b, k, n): the mean squared differences of blocks to what is known of boxes, as `Compared`.

    Where nothing is known nothing differs. What a block does not show is taken to differ as in one of the valid (b, n)
    blocks.
    """
    raw, against, seen, squares = compared.raw, compared.against, compared.inside, np.empty(found.shape[2])
    for box in range(len(found)):
        count, inside = against[box, -1].sum(), np.empty((found.shape[1] + 1, len(squares)))
        if len(seen) > 0:
            inside = seen[box]
        elif compared.hangs:
            inside = sum_boxes(against[box], compared.spans[0], compared.spans[1]).reshape(inside.shape)
        for image in range(found.shape[1]):
            energy = against[box, image].sum()
            for i in range(len(squares)):
                squares[i] = max(raw[box, image, i] + energy, 0.0)
            if compared.hangs or len(seen) > 0:
                _take_fairly(squares, energy, count, inside[image], inside[-1], valid[box], compared.share)
            for i in range(len(squares)):
                mean = squares[i] / (count * compared.scales[image]) if count > 0 else 0.0
                found[box, image, i] = np.rint(mean * compared.steps) / compared.steps


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
def cover(needed: Any, known: Any, corners: Any, covering: Any) -> None:
    """Set which valid blocks are `covering` (n,) all pixels of a box that are needed, but not known (A, B, C).

    corners: `Frame`. Inside of the exemplar those pixels have to lie.
    """
    first, last = np.full(3, 2**62), np.full(3, -1)
    for i in range(needed.shape[0]):
        for j in range(needed.shape[1]):
            for k in range(needed.shape[2]):
                if needed[i, j, k] and not known[i, j, k]:
                    for axis, at in enumerate((i, j, k)):
                        first[axis], last[axis] = min(first[axis], at), max(last[axis], at)
    some, lines, sizes, valid = last[0] >= 0, corners.lines, corners.sizes, corners.valid
    inside = covering.reshape(valid.shape)
    for i, plane in enumerate(lines[0]):
        there = not some or (plane + first[0] >= 0 and plane + last[0] < sizes[0])
        for j, row in enumerate(lines[1]):
            beside = there and (not some or (row + first[1] >= 0 and row + last[1] < sizes[1]))
            for k, column in enumerate(lines[2]):
                within = beside and (not some or (column + first[2] >= 0 and column + last[2] < sizes[2]))
                inside[i, j, k] = within and valid[i, j, k]


@jitted
def count_offsets(places: Any, known: Any, extent: Any, corners: Any, counts: Any) -> None:
    """Count from which corners (b, n) of an exemplar the known pixels of boxes come, those from elsewhere left out.

    places (b, N): of a mosaic of the exemplar alone; known (b, N): whether there is one; extent (axes,): of the boxes;
    corners: `Frame`. A corner's number is its place and what may hang over, in steps of the grain; it is found once for
    what goes on along the last axis.
    """
    counts[:] = 0
    for box in range(len(places)):
        _count_offsets(places[box], known[box], extent, corners, counts[box])


@jitted
def _count_offsets(places: Any, known: Any, extent: Any, corners: Any, counts: Any) -> None:
    axes, cell, hang, grain, shape = len(extent), corners.cell, corners.hang, corners.grain, corners.shape
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
def sum_near(around: Any, near: Any) -> None:
    """Set the sums (b, n) over blocks of how near to a box places are shown (`Around`): 1 in it, 0 where out of reach.

    Their twins count as well.
    """
    places, reach, cell = around.places, around.reach, around.cell
    for box in range(len(near)):
        start, stop, shown = around.starts[box], around.stops[box], np.zeros((1, 1, cell[0], cell[1]))
        low, left = max(start[0] - reach, 0), max(start[1] - reach, 0)
        high, right = min(stop[0] + reach, len(places)), min(stop[1] + reach, places.shape[1])
        part = places[low:high, left:right], around.label[low:high, left:right]
        _sum_near(part[0], part[1], around.twins, low, left, start, stop, reach, shown.ravel())
        copy_into(sum_boxes(shown, around.spans[0], around.spans[1]).ravel(), near[box])


@jitted
def _sum_near(
    places: Any, label: Any, twins: Any, top: Any, left: Any, start: Any, stop: Any, reach: Any, shown: Any
) -> None:
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
                for twin in range(len(twins)):
                    if twins[twin, places[i, j]] >= 0:
                        shown[twins[twin, places[i, j]]] += share[j]
