"""Pixels of a sheet, read in boxes and written there, in compiled loops, which may pass the borders of axes that wrap.

Pixels have three axes (`kwatra.base.spans.volume`): a sheet's `label` (*S), its `places` (k, *S), one or more numbers
each, `fixed` (*S), and the cost of its `seams` (axes, *S) between a pixel and the next.

This module is compiled by numba when first used, so it is imported where a sheet is looked at.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.base.spanloops import sum_boxes
from kwatra.cut.choices import FREE, KEEP, TAKE, VOID
from kwatra.pieces.loops import patch_sides

STRETCH = 64
"""Of so many regions along a line the highest score is known: to look for the highest of all takes no longer than to
score those around a patch. Not tuned."""


@jitted
def look(label: Any, places: Any, starts: Any, shown: Any, known: Any) -> None:
    """Set the places that are `shown` (b, *E) in boxes, and which of them are `known`; starts (b, 3): of the boxes."""
    lines = _lines(shown.shape[1:])
    for box, start in enumerate(starts):
        _follow(start, label.shape, lines)
        for i in range(shown.shape[1]):
            for j in range(shown.shape[2]):
                one, other = lines[0][i], lines[1][j]
                for k in range(shown.shape[3]):
                    last = lines[2][k]
                    shown[box, i, j, k] = places[0, one, other, last]
                    known[box, i, j, k] = label[one, other, last] >= 0


@jitted
def count_most(label: Any, starts: Any, known: Any, patches: Any, most: Any) -> None:
    """Set of which of so many patches `most` (b,) of the known pixels (b, *E) of boxes are, the first of equals.

    starts (b, 3): of the boxes.
    """
    lines = _lines(known.shape[1:])
    for box, start in enumerate(starts):
        most[box] = 0
        if patches == 0:
            continue
        counts = np.zeros(patches, np.int64)
        _follow(start, label.shape, lines)
        for i in range(known.shape[1]):
            for j in range(known.shape[2]):
                one, other = lines[0][i], lines[1][j]
                for k in range(known.shape[3]):
                    if known[box, i, j, k]:
                        counts[label[one, other, lines[2][k]]] += 1
        most[box] = counts.argmax()


@jitted
def look_around(label: Any, places: Any, fixed: Any, seams: Any, seen: Any) -> None:
    """Set what a sheet shows of boxes; seen: where they lie, and the arrays that it is set in (`Pixels`)."""
    kept, laid, held, shown, remembered = seen.kept, seen.laid, seen.fixed, seen.places, seen.remembered
    pixel, cost, missing = 0, 0, 3 - len(seams)
    for box in range(len(seen.starts)):
        a, b, c = seen.extents[box]
        lines = _lines((a, b, c))
        _follow(seen.starts[box], label.shape, lines)
        first, count = len(places) * pixel, a * b * c
        for i in range(a):
            for j in range(b):
                one, other = lines[0][i], lines[1][j]
                for k in range(c):
                    last = lines[2][k]
                    filled = label[one, other, last] >= 0
                    held[pixel] = fixed[one, other, last]
                    kept[pixel] = KEEP if filled else VOID
                    laid[pixel] = KEEP if held[pixel] else FREE if filled else TAKE
                    pixel += 1
        for n in range(len(places)):
            for i in range(a):
                for j in range(b):
                    one, other = lines[0][i], lines[1][j]
                    for k in range(c):
                        shown[first + n * count + (i * b + j) * c + k] = places[n, one, other, lines[2][k]]
        total = np.int64(0)
        for axis in range(missing, 3):
            for i in range(a - (axis == 0)):
                for j in range(b - (axis == 1)):
                    one, other = lines[0][i], lines[1][j]
                    for k in range(c - (axis == 2)):
                        remembered[cost] = seams[axis - missing, one, other, lines[2][k]]
                        total += remembered[cost]
                        cost += 1
        seen.totals[box] = total


@jitted
def places_before(extents: Any) -> Any:
    """How many pixels, and how many pairs of one and the next, come before each box (b,) of extents (b, 3)."""
    pixels, pairs = np.zeros(len(extents), np.int64), np.zeros(len(extents), np.int64)
    for box in range(len(extents) - 1):
        a, b, c = extents[box]
        pixels[box + 1] = pixels[box] + a * b * c
        pairs[box + 1] = pairs[box] + (a - 1) * b * c + a * (b - 1) * c + a * b * (c - 1)
    return pixels, pairs


@jitted
def of_pixels(values: Any, first: Any, extent: Any) -> Any:
    """The values (A, B, C) of a box's pixels, those from a first one on."""
    a, b, c = extent
    return values[first : first + a * b * c].reshape((a, b, c))


@jitted
def of_pairs(values: Any, first: Any, extent: Any) -> Any:
    """The values of pairs of a box's pixels, those from a first one on: along each axis one fewer than it has pixels.

    That is none along those that there are not.
    """
    a, b, c = extent
    second = first + (a - 1) * b * c
    third = second + a * (b - 1) * c
    last = third + a * b * (c - 1)
    one, two, three = values[first:second], values[second:third], values[third:last]
    return one.reshape((a - 1, b, c)), two.reshape((a, b - 1, c)), three.reshape((a, b, c - 1))


@jitted
def lay_each(
    label: Any, places: Any, seams: Any, seen: Any, numbers: Any, take: Any, shown: Any, left: Any, counts: Any
) -> None:
    """Have the pixels of boxes that `take` (N,) a patch show its places, and set all seams that are `left` (M,).

    seen: what the boxes showed before (`Pixels`); shown: what they do now, laid out as there. numbers (b,): of their
    patches, below 0 where none is laid. counts (cells,): how often each place is shown, counted anew; of none where
    that is not asked for.
    """
    pixels, pairs = places_before(seen.extents)
    for box in range(len(numbers)):
        if numbers[box] >= 0:
            a, b, c = seen.extents[box]
            first, last = len(places) * pixels[box], len(places) * (pixels[box] + a * b * c)
            new = shown[first:last].reshape((len(places), a, b, c))
            taken, after = (
                of_pixels(take, pixels[box], seen.extents[box]),
                of_pairs(left, pairs[box], seen.extents[box]),
            )
            _lay(label, places, seams, seen.starts[box], numbers[box], taken, new, after)
            if len(counts) > 0:
                kept = of_pixels(seen.kept, pixels[box], seen.extents[box]).ravel()
                _recount(taken.ravel(), new.ravel(), seen.places[first:last], kept, counts)


@jitted
def _recount(take: Any, new: Any, old: Any, kept: Any, counts: Any) -> None:
    """Count each place (M,) once more for each pixel (N,) that will show it, once less for each that no longer does.

    take: which pixels take a patch; new, old: its places, and those that are shown; kept: KEEP where there are any.
    """
    for i in range(len(take)):
        if take[i]:
            counts[np.int64(new[i])] += 1
            if kept[i] == KEEP:
                counts[np.int64(old[i])] -= 1


@jitted
def _lay(label: Any, places: Any, seams: Any, start: Any, number: Any, take: Any, shown: Any, left: Any) -> None:
    """The same of one box (*E) that begins at start: places (k, *E) of the patch, and seams as of `of_pairs`."""
    lines = _lines(take.shape)
    _follow(start, label.shape, lines)
    for i in range(take.shape[0]):
        for j in range(take.shape[1]):
            one, other = lines[0][i], lines[1][j]
            for k in range(take.shape[2]):
                if take[i, j, k]:
                    last = lines[2][k]
                    label[one, other, last] = number
                    for n in range(len(places)):
                        places[n, one, other, last] = shown[n, i, j, k]
    missing = len(left) - len(seams)
    for axis in range(missing, len(left)):
        cost, seam = left[axis], seams[axis - missing]
        for i in range(cost.shape[0]):
            for j in range(cost.shape[1]):
                one, other = lines[0][i], lines[1][j]
                for k in range(cost.shape[2]):
                    seam[one, other, lines[2][k]] = cost[i, j, k]


@jitted
def count_kept(seen: Any, firsts: Any, shifts: Any, bounds: Any, counts: Any) -> None:
    """Count (n,) the pixels of boxes (`Pixels`) that are KEEP where patches lie, those of one box after the other.

    firsts (b + 1,): which is the first of each box, and how many there are; shifts (n, AXES), bounds (b, 3, AXES): as
    of `patch_sides`.
    """
    pixels, _ = places_before(seen.extents)
    for box in range(len(bounds)):
        kept = of_pixels(seen.kept, pixels[box], seen.extents[box])
        first, last = firsts[box], firsts[box + 1]
        starts, stops = patch_sides(shifts[first:last], bounds[box])
        for number in range(last - first):
            count = 0
            for i in range(starts[number, 0], stops[number, 0]):
                for j in range(starts[number, 1], stops[number, 1]):
                    for k in range(starts[number, 2], stops[number, 2]):
                        count += kept[i, j, k] == KEEP
            counts[first + number] = count


@jitted
def score(seams: Any, tried: Any, low: Any, high: Any, extent: Any, scores: Any, highest: Any) -> None:
    """Set the scores of regions of `extent` (3,) that begin from low (3,) to before high (3,), and the highest ones.

    A score (*n) is what the seams within a region cost, times what a region that begins there counts (`tried`, *S).
    highest: as of `find_highest`.
    """
    shape = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    lines = _lines((shape[0] + extent[0] - 1, shape[1] + extent[1] - 1, shape[2] + extent[2] - 1))
    _follow(low, tried.shape, lines)
    under = np.zeros((1, len(lines[0]), len(lines[1]), len(lines[2])))
    for seam in seams:
        for i in range(under.shape[1]):
            for j in range(under.shape[2]):
                one, other = lines[0][i], lines[1][j]
                for k in range(under.shape[3]):
                    under[0, i, j, k] += seam[one, other, lines[2][k]]
    starts = np.arange(shape[0]), np.arange(shape[1]), np.arange(shape[2])
    stops = starts[0] + extent[0], starts[1] + extent[1], starts[2] + extent[2]
    sums = sum_boxes(under, starts, stops)
    for i in range(shape[0]):
        for j in range(shape[1]):
            one, other = lines[0][i], lines[1][j]
            for k in range(shape[2]):
                last = lines[2][k]
                scores[one, other, last] = sums[0, i, j, k] * tried[one, other, last]
    find_highest(scores, low, shape, highest)


@jitted
def find_highest(scores: Any, low: Any, extent: Any, highest: Any) -> None:
    """Set the highest scores (*n) of each STRETCH of the last axis in which a box of an extent lies that begins at low.

    highest (*n[:-1], s): of all stretches of a line, the last of which may be shorter.
    """
    lines, most = _lines(extent), np.uint64(STRETCH)
    _follow(low, scores.shape, lines)
    for i in range(extent[0]):
        for j in range(extent[1]):
            one, other = lines[0][i], lines[1][j]
            for k in range(extent[2]):
                stretch = lines[2][k] // most
                if k == 0 or stretch != lines[2][k - 1] // most:
                    first = stretch * most
                    highest[one, other, stretch] = scores[one, other, first : first + most].max()


@jitted
def _lines(extent: Any) -> Any:
    """Room for the numbers of planes, rows and columns of boxes: never negative, which saves asking each time."""
    return np.empty(extent[0], np.uint64), np.empty(extent[1], np.uint64), np.empty(extent[2], np.uint64)


@jitted
def _follow(start: Any, shape: Any, lines: Any) -> None:
    """Set the numbers of a box's planes, rows and columns in a sheet of some shape."""
    for axis in range(3):
        for i in range(len(lines[axis])):
            lines[axis][i] = (start[axis] + i) % shape[axis]
