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
def correlate(ones: Any, others: Any, total: Any) -> None:
    """Sum the products (N,) of the conjugates of ones (k, N) with others (k, N)."""
    total[:] = 0
    for one, other in zip(ones, others):  # noqa: B905 - not in compiled loops
        for i in range(len(total)):
            total[i] += one[i].conjugate() * other[i]


@jitted
def quantile(values: Any, share: Any) -> Any:
    """What a share, 0 to 1, of some numbers (N,) is no larger than, as `np.quantile` has it."""
    at = share * (len(values) - 1)
    first = int(at)
    some = np.partition(values, first)
    low = some[first]
    high = some[first + 1 :].min() if first + 1 < len(some) else low
    past, step = at - first, high - low
    return high - step * (1 - past) if past >= 0.5 else low + step * past


@jitted
def take_fairly(squares: Any, seen: Any, valid: Any, count: Any, share: Any, summed: Any) -> None:
    """Sum blocks' squared differences (N,) over `count` pixels, those not `seen` (N,) taken to be as a fair block's.

    That is the mean square which the share of `valid` (N,) blocks does not exceed.
    """
    means, blocks = np.empty(len(squares)), 0
    for i in range(len(squares)):
        if valid[i]:
            means[blocks] = squares[i] / max(seen[i], 1)
            blocks += 1
    fair = quantile(means[:blocks], share)
    for i in range(len(squares)):
        summed[i] = squares[i] + (count - seen[i]) * fair


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
def count_offsets(places: Any, known: Any, extent: Any, cell: Any, hang: Any, grain: Any, counts: Any) -> None:
    """Count from which corners (*n) of an exemplar the known pixels of a box come, those from elsewhere left out.

    places (N,): of a mosaic of the exemplar alone, cells of `cell` (axes,); known (N,): whether there is one; extent
    (axes,): of the box. A corner's number is its place and what may `hang` over, in steps of grain; it is found once
    for what goes on along the last axis.
    """
    flat, axes = counts.ravel(), len(extent)
    number, found = 0, False
    for pixel in range(len(places)):
        if not known[pixel]:
            continue
        if pixel % extent[-1] == 0 or not known[pixel - 1] or places[pixel] != places[pixel - 1] + 1:
            there, here, number, stride, found = places[pixel], pixel, 0, 1, True
            for axis in range(axes - 1, -1, -1):
                first = there % cell[axis] - 1 - here % extent[axis] + hang[axis]
                step = first // grain[axis]
                found = found and first >= 0 and step < counts.shape[axis]
                number += step * stride
                stride *= counts.shape[axis]
                there //= cell[axis]
                here //= extent[axis]
        if found:
            flat[number] += 1


@jitted
def take_known(image: Any, places: Any, known: Any, content: Any) -> None:
    """The values (C, N) of an image (C, M) at its places (N,) where they are known (N,), and 0 elsewhere."""
    for channel in range(len(image)):
        for pixel in range(len(known)):
            content[channel, pixel] = image[channel, places[pixel]] if known[pixel] else 0


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
