"""Cells warped along rays from their middles, in compiled loops; windows and copies are as in `loops`.

This module is compiled by numba when first used, so it is imported where cells are fitted.
"""

from typing import Any

import numpy as np

from kwatra.base.compiled import jitted
from kwatra.pieces.cells.loops import BEYOND, between, seen, window

STEP = 0.5
"""px between points of a ray that are looked at."""

NEAR = 0.1
"""px between places that are looked at for the last one in a cell. Where it was .75 joints came out dotted."""

RIM = 0.7
"""px beyond an element, where its colors are mixed with the ground's, that are neither stretched nor squeezed. Two
stills each of ten textures score .083 with it, .087 if ground begins at once where the element ends, as does the
exemplar's where its colors are no longer mixed."""

LOOSELY = 16
"""Outlines of loose elements are as smooth as the mean over a turn by this on both sides. Of coins of 20 and 32 px in a
pair of vortices motion is off by .21 and .30 px with 16, .22 and .33 with 8; by eye, dents are as round."""

THIN = 0.5
"""Ground that is less wide, as a part of what is narrow, of loose elements of what is usual around one, shows nothing
but its rim. Where it is shown all the same stones of 50 px in a pair of vortices are off by .31 px in place of .29, and
.09 of tiles of 32 px become too large in place of .01; five stills of pebbles of 14 px score .096 in place of .097."""


@jitted
def seen_from_middle(windows: Any, aways: Any, elements: Any, rays: Any, share: Any, gaps: Any) -> None:
    """Set the share of each element that is seen from the middle of its cell (n,), 0 to 1, along so many rays.

    gaps (n, rays): how wide the ground is between the element and its cell's border along each, px.
    """
    cell_at = np.empty(rays)
    share[0], gaps[0] = 0, 0
    for cell in range(1, len(share)):
        away, element = window(windows, aways, cell), window(windows, elements, cell)
        middle = _middle(away)
        _reach(0.5 - element, middle, gaps[cell])
        _reach(away, middle, cell_at)
        area = np.square(gaps[cell]).sum() * np.pi / rays
        in_it = element[int(np.rint(middle[0])), int(np.rint(middle[1]))]
        share[cell] = min(area / max(element.sum(), 1), 1.0) if in_it else 0.0
        gaps[cell] = np.maximum(cell_at - gaps[cell], 0)


@jitted
def warp(
    windows: Any, aways: Any, elements: Any, whole: Any, laid: Any, rays: Any, most: Any, gaps: Any, best: Any,
    second: Any, owner: Any, written: Any, where: Any,
) -> None:  # fmt: skip
    """Have the share of each copy show its whole cell: set places `where` (2, H, W) that are `written` (H, W).

    Places are between pixels. rays: along so many the border of a share becomes that of the cell. most: elements are
    stretched and squeezed along one by no more, while they need not be. gaps (2,): as of `_shown`. best, second, owner:
    as of `divide`. whole (n,): whether nothing cuts a cell's element; one that the border cuts gets ground on that side
    too, as wide as beside it. Whole ones do not where theirs is thin: halves of two nuts that touch would be notched.
    """
    share_at, cell_at, element_at, shown_at = np.empty(rays), np.empty(rays), np.empty(rays), np.empty(rays)
    beside = np.empty(rays, np.int64)
    some = _some(len(laid[0]), owner, written)
    for m in range(len(some)):
        if not some[m]:
            continue
        away, to, (top, left) = seen(windows, aways, laid, m, BEYOND), laid[1][m], laid[2][m]
        both, outside = _outside(away, top, left, m, laid[4][m], best, second, owner)
        middle = _middle(both)
        if middle[0] < 0:
            continue
        _reach(outside, middle, share_at)
        _reach(away, middle, cell_at)
        _reach(0.5 - seen(windows, elements, laid, m, 0.0), middle, element_at)
        element_at = np.minimum(element_at, cell_at)
        ground = cell_at - element_at
        _with_ground(ground, gaps, beside)
        _shown(share_at, element_at, ground if whole[laid[0][m]] else ground[beside], gaps, shown_at)
        for i in range(max(-top, 0), min(away.shape[0], owner.shape[0] - top)):
            for j in range(max(-left, 0), min(away.shape[1], owner.shape[1] - left)):
                y, x = i + top, j + left
                if owner[y, x] == m and written[y, x]:
                    off = _there(i - middle[0], j - middle[1], share_at, cell_at, element_at, shown_at, beside, most)
                    row, column = _inside(away, middle, off[0], off[1])
                    for axis in range(2):
                        where[axis, y, x] = to[axis, 0] * (row + top) + to[axis, 1] * (column + left) + to[axis, 2]


@jitted
def _some(copies: Any, owner: Any, written: Any) -> Any:
    """Of which copies (m,) anything is written."""
    some = np.zeros(copies, np.bool_)
    for i in range(owner.shape[0]):
        for j in range(owner.shape[1]):
            if written[i, j]:
                some[owner[i, j]] = True
    return some


@jitted
def _outside(away: Any, top: Any, left: Any, m: Any, push: Any, best: Any, second: Any, owner: Any) -> Any:
    """How far outside of a copy's share pixels are, px, below 0 inside, and of the share and the cell; two (h, w).

    Beyond an output it is as `away` (h, w), from (top, left) on.
    """
    outside, both = away.copy(), away.copy()
    for i in range(max(-top, 0), min(away.shape[0], owner.shape[0] - top)):
        for j in range(max(-left, 0), min(away.shape[1], owner.shape[1] - left)):
            y, x = i + top, j + left
            if owner[y, x] == m:
                outside[i, j] = max(best[y, x] - second[y, x], -2 * len(away)) / 2
            else:
                outside[i, j] = max(away[i, j] - push - best[y, x], 0.5) / 2
            both[i, j] = max(outside[i, j], away[i, j])
    return both, outside


@jitted
def _middle(outside: Any) -> Any:
    """Where it is deepest inside, (row, column), between pixels; below 0 if nothing is inside.

    It is the mean of places weighted by a power of how deep they are, which does not jump.
    """
    total, down, right = 0.0, 0.0, 0.0
    for i in range(outside.shape[0]):
        for j in range(outside.shape[1]):
            if outside[i, j] < 0:
                weight = outside[i, j] ** 4
                total += weight
                down += weight * i
                right += weight * j
    middle = (down / total, right / total) if total > 0 else (-1.0, -1.0)
    inside = total > 0 and outside[int(np.rint(middle[0])), int(np.rint(middle[1]))] < 0
    return middle if inside else (-1.0, -1.0)


@jitted
def _reach(outside: Any, middle: Any, at: Any) -> None:
    """Set how far it is from the middle of a window along rays (k,), evenly around, until values are no longer < 0.

    In the mean over two pixels of the border, as what is told by pixels has steps.
    """
    reached = np.empty(len(at))
    start = between(outside, middle[0], middle[1])
    for k in range(len(at)):
        angle = 2 * np.pi * k / len(at)
        down, right = np.sin(angle), np.cos(angle)
        far, before, now = 0.0, start, start
        while now < 0:
            far, before = far + STEP, now
            row, column = middle[0] + down * far, middle[1] + right * far
            if not (0 <= row < outside.shape[0] - 1 and 0 <= column < outside.shape[1] - 1):
                break
            now = between(outside, row, column)
        reached[k] = max(far - STEP * now / (now - before), STEP) if now >= 0 and now > before else max(far, STEP)
    _spread(reached, round(len(at) / (2 * np.pi * reached.mean())), at)


@jitted
def _spread(values: Any, near: Any, means: Any) -> None:
    """Set the means of values (k,) that lie around a circle and their so many neighbors on both sides."""
    count = len(values)
    near = min(near, count // 8)
    for k in range(count):
        total = 0.0
        for n in range(k - near, k + near + 1):
            total += values[n % count]
        means[k] = total / (2 * near + 1)


@jitted
def _shown(share_at: Any, element_at: Any, ground: Any, gaps: Any, shown_at: Any) -> None:
    """Set how far an element reaches in its share along rays (k,).

    The ground around it (k,) stays as wide as it is between gaps (2,), px: elements are squeezed that leave less than
    the first, or than they have, and stretched that leave more than the second. Where ground is wider than narrow gaps
    outlines stay as smooth as that: no more than their neighbors are elements drawn out into corners of their share.
    """
    rays = len(share_at)
    ratios, least = np.empty(rays), np.empty(rays)
    for k in range(rays):
        share, gap = share_at[k], ground[k]
        most = max(element_at[k], share - max(gap, gaps[1]))
        ratios[k] = min(most, max(share - min(gap, gaps[0]), 0.5 * share)) / element_at[k]
    near = rays // LOOSELY
    if gaps[1] < np.inf:
        near = min(round(max(gaps[1] - gaps[0], 0) * rays / (2 * np.pi * element_at.mean())), rays // 8)
    for k in range(rays):
        least[k] = ratios[k]
        for n in range(k - near, k + near + 1):
            least[k] = min(least[k], ratios[n % rays])
    _spread(least, near, shown_at)
    shown_at *= element_at


@jitted
def _with_ground(gap: Any, gaps: Any, beside: Any) -> None:
    """Set for each ray (k,) the nearest along which a cell's ground is not thin; gap (k,): how wide it is, px."""
    rays, least = len(gap), THIN * (np.median(gap) if gaps[1] == np.inf else gaps[0])
    for k in range(rays):
        beside[k] = k
        for n in range(rays // 2 + 1):
            if gap[(k + n) % rays] >= least:
                beside[k] = (k + n) % rays
                break
            if gap[(k - n) % rays] >= least:
                beside[k] = (k - n) % rays
                break


@jitted
def _there(
    down: Any, right: Any, share_at: Any, cell_at: Any, element_at: Any, shown_at: Any, beside: Any, most: Any
) -> Any:  # fmt: skip
    """How far from the middle (rows, columns) that lies in a cell which is shown so far from it in the share."""
    far = np.sqrt(down * down + right * right)
    if far == 0:
        return down, right
    at = np.arctan2(down, right) / (2 * np.pi) * len(share_at) % len(share_at)
    k, part = int(at) % len(share_at), at - int(at)
    after = (k + 1) % len(share_at)
    share = share_at[k] * (1 - part) + share_at[after] * part
    cell = cell_at[k] * (1 - part) + cell_at[after] * part
    element = element_at[k] * (1 - part) + element_at[after] * part
    shown = shown_at[k] * (1 - part) + shown_at[after] * part
    if far >= shown:
        down, right = down / far, right / far
        if beside[k] != k:
            cell, element = cell_at[beside[k]], element_at[beside[k]]
            angle = 2 * np.pi * beside[k] / len(share_at)
            down, right = np.sin(angle), np.cos(angle)
        beyond, rim = min(far, share) - shown, max(min(RIM, cell - element, share - shown), 0.0)
        to = element + beyond
        if beyond > rim:
            to = element + rim + (beyond - rim) * (cell - element - rim) / max(share - shown - rim, 1e-3)
        return down * to, right * to
    rigid = min((most * shown - element) / (most - 1), (most * element - shown) / (most - 1))
    rigid = min(max(rigid, 0.1 * min(shown, element)), min(shown, element))
    if far <= rigid:
        return down, right
    scale = (rigid + (far - rigid) * (element - rigid) / (shown - rigid)) / far
    return down * scale, right * scale


@jitted
def _inside(away: Any, middle: Any, down: Any, right: Any) -> Any:
    """The place of a window so far from its middle, or the last before it that is in the cell."""
    far = np.sqrt(down * down + right * right)
    less = NEAR / max(far, NEAR)
    for k in range(int(far / NEAR) + 1):
        row, column = middle[0] + (1 - k * less) * down, middle[1] + (1 - k * less) * right
        i, j = int(np.rint(row)), int(np.rint(column))
        if 0 <= i < away.shape[0] and 0 <= j < away.shape[1] and away[i, j] < 0:
            return row, column
    return middle
