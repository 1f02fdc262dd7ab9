"""Loops over the pixels of a window or an exemplar that choosing a block takes, compiled.

This module is compiled by numba when first used, so it is imported where a block is chosen.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted


@jitted
def sum_spans(values: Any, starts: Any, stops: Any, sums: Any) -> None:
    """Sums (before, spans, behind) of values (before, along, behind) from each start to before its stop."""
    table = np.zeros((values.shape[1] + 1, values.shape[2]), sums.dtype)
    for i in range(values.shape[0]):
        if values.shape[2] == 1:  # the last axis: loops over nothing behind it take twice as long
            _sum_line(values[i, :, 0], starts, stops, table[:, 0], sums[i, :, 0])
            continue
        for j in range(values.shape[1]):
            _add(table[j], values[i, j], table[j + 1])
        for span in range(len(starts)):
            _subtract(table[stops[span]], table[starts[span]], sums[i, span])


@jitted
def _add(one: Any, other: Any, total: Any) -> None:
    for k in range(len(total)):
        total[k] = one[k] + other[k]


@jitted
def _subtract(one: Any, other: Any, rest: Any) -> None:
    for k in range(len(rest)):
        rest[k] = one[k] - other[k]


@jitted
def _sum_line(values: Any, starts: Any, stops: Any, table: Any, sums: Any) -> None:
    for j in range(len(values)):
        table[j + 1] = table[j] + values[j]
    for span in range(len(starts)):
        sums[span] = table[stops[span]] - table[starts[span]]


@jitted
def count_offsets(place: Any, known: Any, extent: Any, hang: Any, grain: Any, counts: Any) -> None:
    """Count from which corners (*n) of an exemplar the known pixels of a box come, those from elsewhere left out.

    place (axes, N): in the exemplar; known (N,): whether there is one; extent (axes,): of the box; a corner's number is
    its place and what may `hang` over, in steps of grain. It is found once for what goes on along the last axis.
    """
    flat, axes = counts.ravel(), len(extent)
    number, found = 0, False
    for pixel in range(len(known)):
        goes_on = pixel % extent[-1] > 0
        for axis in range(axes):
            goes_on = goes_on and place[axis, pixel] == place[axis, pixel - 1] + (axis == axes - 1)
        if not goes_on:
            rest, number, stride, found = pixel, 0, 1, True
            for axis in range(axes - 1, -1, -1):
                first = place[axis, pixel] - rest % extent[axis] + hang[axis]
                step = first // grain[axis]
                found = found and first >= 0 and step < counts.shape[axis]
                number += step * stride
                stride *= counts.shape[axis]
                rest //= extent[axis]
        if found and known[pixel]:
            flat[number] += 1


@jitted
def take_known(image: Any, shape: Any, place: Any, known: Any, content: Any) -> None:
    """The values (C, N) of an image (C, M) at places (axes, N) where they are known (N,), and 0 elsewhere.

    shape (axes,): of the image.
    """
    content[:] = 0
    for pixel in range(len(known)):
        if known[pixel]:
            there = 0
            for axis in range(len(shape)):
                there = there * shape[axis] + place[axis, pixel]
            for channel in range(len(image)):
                content[channel, pixel] = image[channel, there]


@jitted
def locate(places: Any, cell: Any, strides: Any, number: Any, at: Any) -> None:
    """The source's number (N,) and the coordinates in it (axes, N) of places (N,) of a mosaic.

    cell: how many places a source takes; strides (axes,): from a place to the next along each axis.
    """
    for i in range(len(places)):
        number[i], rest = divmod(places[i], cell)
        for axis in range(len(strides)):
            step, rest = divmod(rest, strides[axis])
            at[axis, i] = step - 1


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
