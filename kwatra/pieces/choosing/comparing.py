"""What is known of boxes, and how blocks that may be laid in them compare with it, in compiled loops.

Boxes (b,) of one extent are worked on together. Arrays of their pixels have three axes (`kwatra.base.spans.volume`), or
are flat (b, N); those over the blocks that may be laid in each (b, n) too.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.spanloops import sum_boxes
from kwatra.pieces.loops import copy_into, quantile


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
    raw: Any, against: Any, seen: Any, hangs: Any, spans: Any, valid: Any, share: Any, scales: Any, steps: Any,
    found: Any,
) -> None:  # fmt: skip
    """Set what is `found` (b, k, n): of k images the mean squared differences of blocks to what is known of boxes.

    It is in units of their scales (k,), to 1 / steps. raw (b, k, n): the squared differences, less the energy of what
    is known. against (b, k + 1, A, B, C): of each pixel that energy, and whether it is known; where none is nothing
    differs. seen (b, k + 1, n): the sums of both over what each block shows; of no boxes where it shows all but what
    hangs over the image. hangs: whether any does; spans: of each axis the first pixels of boxes that do not with a
    block, and those after the last. What is not shown is taken to differ as in that one of the valid (b, n) blocks
    which a share of them are no worse than.
    """
    squares = np.empty(found.shape[2])
    for box in range(len(found)):
        count, inside = against[box, -1].sum(), np.empty((found.shape[1] + 1, len(squares)))
        if len(seen) > 0:
            inside = seen[box]
        elif hangs:
            inside = sum_boxes(against[box], spans[0], spans[1]).reshape(inside.shape)
        for image in range(found.shape[1]):
            energy = against[box, image].sum()
            for i in range(len(squares)):
                squares[i] = max(raw[box, image, i] + energy, 0.0)
            if hangs or len(seen) > 0:
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
def sum_near(
    places: Any, label: Any, twins: Any, starts: Any, stops: Any, reach: Any, cell: Any, spans: Any, near: Any
) -> None:
    """Set the sums (b, n) over blocks of how near to a box each place is shown: 1 in it, 0 from `reach` away.

    places, label (H, W): what pixels show of a mosaic's `cell` (2,), and of which patch, < 0 of none. twins (t, cells):
    what is shown of each place as well, < 0 for nothing. starts, stops (b, 2): of the boxes. spans: of each of three
    axes the first places under blocks, and those after the last.
    """
    for box in range(len(starts)):
        start, stop, shown = starts[box], stops[box], np.zeros((1, 1, cell[0], cell[1]))
        low, left = max(start[0] - reach, 0), max(start[1] - reach, 0)
        high, right = min(stop[0] + reach, len(places)), min(stop[1] + reach, places.shape[1])
        around = places[low:high, left:right], label[low:high, left:right]
        _sum_near(around[0], around[1], twins, low, left, start, stop, reach, shown.ravel())
        copy_into(sum_boxes(shown, spans[0], spans[1]).ravel(), near[box])


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
