"""Metamorphosis under texton masks as published (Tonietto and Walter, Texture Metamorphosis Driven by Texton Masks,
2005, section 3): pixel by pixel in raster order, after Wei and Levoy (2000).

Frame k is grown over frame k - 1, which is blocks of A at random before the first. At every pixel, the window of the
last mask finds its best match in either mask (steps 1 and 2); their values, mixed, are the new mask (3, 4). The window
of the frame, new above and old below, finds its best match in A among the pixels of the one value and in B among
those of the other (5, 6); their colors, mixed, are the new pixel (7). Windows are weighted by a Gaussian, and sources
and frames are periodic.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kwatra.base.compiled import jitted

Array = NDArray[np.float32]
Index = NDArray[np.int64]

_BLOCK = 8
"""Px of the blocks, at random places, that a first frame is made of."""
_AXES = 48
"""Principal components along which windows are compared before they are in full: time grows with it."""
_AT_ONCE = 256
"""Windows that are compared at a time: the bound on memory."""
_ROUNDING = 1e-6
"""By so much a bound may be off."""


class _Source(NamedTuple):
    """A source as it is searched: the first `ground` of its places have the mask's value 0, the others 1.

    padded (h + 2 reach, (w + 2 reach) C), rows of pixels; mask (h, w); roots (width, width C) of its weights, row
    by row; rows (width,), the middle one first; axes (width width C, D), the principal ones of its windows; places
    (N, 2), their windows along the axes, (N, D), and half their squares, (N,).
    """

    padded: Array
    mask: Array
    roots: Array
    rows: Index
    axes: Array
    places: Index
    along: Array
    half: Array
    ground: int


def grown(
    images: tuple[Array, Array], masks: tuple[Array, Array], widths: tuple[int, int], shape: tuple[int, int],
    times: Sequence[float], seed: int,
) -> Iterator[tuple[Array, Array]]:  # fmt: skip
    """The frames (H, W, C) and their masks (H, W) at times from 0, A, to 1, B, one after the other.

    images (h, w, C) in [0, 1] and masks (h, w) of 0 and 1, of A and of B; widths of their windows, odd; shape: (H, W).
    """
    a, b = (_source(image, mask, width) for image, mask, width in zip(images, masks, widths, strict=True))
    mask_a, mask_b = (_mask_source(mask, width) for mask, width in zip(masks, widths, strict=True))
    frame, mask = _blocks(images[0], masks[0], shape, np.random.default_rng(seed))
    found_a, found_b, seen_a, seen_b = np.zeros((4, *shape, 2), np.int64)
    for time in times:
        share = 1.0 - time
        _match(mask[..., None], mask_a, seen_a)
        _match(mask[..., None], mask_b, seen_b)
        value_a, value_b = (
            of[tuple(np.moveaxis(seen, -1, 0))] for of, seen in zip(masks, (seen_a, seen_b), strict=True)
        )
        mask = (share * value_a + (1 - share) * value_b).astype(np.float32)
        frame = frame.copy()
        _scan(frame, share, a, value_a, found_a, b, value_b, found_b)
        yield frame, mask


def _mask_source(mask: Array, width: int) -> _Source:
    """A source's mask (h, w), to be searched as an image; windows have their middle, and every place is allowed."""
    weights = _weights(width)
    weights[width // 2, width // 2] = weights.max()  # it counts as its neighbors do
    return _searched(mask[..., None], np.zeros_like(mask), weights)


def _source(image: Array, mask: Array, width: int) -> _Source:
    """A source's image (h, w, C), of which places with one value of the mask (h, w) are searched at a time."""
    return _searched(image, mask, _weights(width))


def _searched(image: Array, mask: Array, weights: Array) -> _Source:
    width, channels = len(weights), image.shape[2]
    roots = np.ascontiguousarray(np.sqrt(weights).repeat(channels, 1))
    padded = _padded(image, width // 2)
    windows = _windows(padded, roots, channels)
    centered = windows - windows.mean(0)
    axes = np.ascontiguousarray(np.linalg.eigh(centered.T @ centered)[1][:, ::-1][:, :_AXES], np.float32)
    along = windows @ axes
    order = np.argsort(mask.reshape(-1), kind="stable")
    places, along = np.stack(np.unravel_index(order, mask.shape), 1), np.ascontiguousarray(along[order])
    half = np.square(along).sum(1) / 2
    rows = np.argsort(abs(np.arange(width) - width // 2), kind="stable")
    return _Source(padded, mask, roots, rows, axes, places, along, half, int((mask == 0).sum()))


def _blocks(image: Array, mask: Array, shape: tuple[int, int], random: np.random.Generator) -> tuple[Array, Array]:
    """A frame and a mask of blocks of a source at random places."""
    y, x = np.indices(shape)
    rows, columns = (-(-side // _BLOCK) for side in shape)
    shifts = random.integers(0, image.shape[:2], (rows, columns, 2))[y // _BLOCK, x // _BLOCK]
    y, x = (y + shifts[..., 0]) % image.shape[0], (x + shifts[..., 1]) % image.shape[1]
    return image[y, x], mask[y, x]


def _weights(width: int) -> Array:
    """The Gaussian weights (width, width) of a window's pixels but its middle, sum 1."""
    away = np.square(np.arange(width) - width // 2)
    weights = np.exp(-(away[:, None] + away) / (2 * (width / 4) ** 2)).astype(np.float32)
    weights[width // 2, width // 2] = 0
    return weights / weights.sum()


def _padded(image: Array, reach: int) -> Array:
    """A periodic image (h, w, C) with so many pixels more on each side, as rows (h + 2 reach, (w + 2 reach) C)."""
    padded = np.pad(image, ((reach, reach), (reach, reach), (0, 0)), mode="wrap")
    return np.ascontiguousarray(padded.reshape(len(padded), -1), np.float32)


def _windows(padded: Array, roots: Array, channels: int) -> Array:
    """The weighted windows of a padded image, as (h * w, width * width * C)."""
    windows = np.lib.stride_tricks.sliding_window_view(padded, roots.shape)[:, ::channels]
    return (windows * roots).reshape(-1, roots.size)


def _match(mask: Array, source: _Source, found: Index) -> None:
    """Steps 1 and 2: the places (H, W, 2) that windows of a mask (H, W, 1) match best, over those of the last frame."""
    windows = _windows(_padded(mask, len(source.rows) // 2), source.roots, 1)
    for first in range(0, len(windows), _AT_ONCE):
        part = windows[first : first + _AT_ONCE]
        along: Any = part @ source.axes
        _match_part(part, np.square(along).sum(1) / 2, source.half - along @ source.along.T, source, found, first)


@jitted
def _match_part(windows: Array, own: Array, half: Array, source: _Source, found: Index, first: int) -> None:
    """Matches of some windows (n, K), the first of which is that of a pixel's number; half (n, N), see `_nearest`."""
    for number in range(len(windows)):
        y, x = divmod(first + number, found.shape[1])
        window = windows[number].reshape(source.roots.shape)
        best, least = _continued(window, source, np.float32(0), found, y, x)
        if least > 0:  # no window is nearer than the same one
            best = _among(window, source, 0, half[number], own[number], best, least)
        found[y, x] = best


@jitted
def _scan(
    frame: Array, share: float, a: _Source, value_a: Array, found_a: Index, b: _Source, value_b: Array, found_b: Index
) -> None:
    """Steps 5 to 7 over a frame (H, W, C), in place, and over the matches (H, W, 2) that the last frame found."""
    height, width, channels = frame.shape
    reach_a, reach_b = len(a.rows) // 2, len(b.rows) // 2
    for y in range(height):
        for x in range(width):
            found_a[y, x] = _nearest(_window(frame, y, x, a), a, value_a[y, x], found_a, y, x)
            found_b[y, x] = _nearest(_window(frame, y, x, b), b, value_b[y, x], found_b, y, x)
            (row_a, column_a), (row_b, column_b) = found_a[y, x], found_b[y, x]
            for c in range(channels):
                one = a.padded[row_a + reach_a, (column_a + reach_a) * channels + c]
                two = b.padded[row_b + reach_b, (column_b + reach_b) * channels + c]
                frame[y, x, c] = share * one + (1 - share) * two


@jitted
def _window(frame: Array, y: int, x: int, source: _Source) -> Array:
    """The weighted window (width, width * C) of a frame at (y, x)."""
    height, width, channels = frame.shape
    size = len(source.rows)
    window = np.empty(source.roots.shape, np.float32)
    for i in range(size):
        row = (y + i - size // 2) % height
        for j in range(size):
            column = (x + j - size // 2) % width
            for c in range(channels):
                window[i, j * channels + c] = frame[row, column, c] * source.roots[i, j * channels + c]
    return window


@jitted
def _nearest(window: Array, source: _Source, wanted: Any, found: Index, y: int, x: int) -> Index:
    """The place (2,) of a source, of the wanted mask value, whose window is nearest to a window (width, width * C).

    It is exact. The distance along the principal axes is never more than the whole one, so only places are compared
    whole that are near along these; the match of the last frame, those above and to the left continued, and the
    nearest along the axes are a small distance to begin with.
    """
    best, least = _continued(window, source, wanted, found, y, x)
    begin, end = (0, source.ground) if wanted == 0 else (source.ground, len(source.places))
    if begin == end:
        return best
    along = np.dot(window.reshape(window.size), source.axes)
    half = source.half[begin:end] - np.dot(source.along[begin:end], along)
    return _among(window, source, begin, half, np.dot(along, along) / 2, best, least)


@jitted
def _continued(window: Array, source: _Source, wanted: Any, found: Index, y: int, x: int) -> tuple[Index, Any]:
    """The best of the match of the last frame and those above and to the left continued, and its squared distance."""
    rows, columns = source.mask.shape
    best = np.zeros(2, np.int64)
    least: Any = np.float32(np.inf)
    above, left, last = found[y - 1, x], found[y, x - 1], found[y, x]
    for row, column in ((above[0] + 1, above[1]), (left[0], left[1] + 1), (last[0], last[1])):
        row, column = row % rows, column % columns
        if source.mask[row, column] == wanted:
            away = _away(window, source, row, column, least)
            if away < least:
                best[0], best[1], least = row, column, away
    return best, least


@jitted
def _among(window: Array, source: _Source, begin: int, half: Array, own: Any, best: Index, least: Any) -> Index:
    """The nearest of the places from `begin` on, or the best so far; own + half: half their distances on the axes."""
    row, column = source.places[begin + half.argmin()]
    away = _away(window, source, row, column, least)
    if away < least:
        best[0], best[1], least = row, column, away
    for number in range(len(half)):
        if 2 * (half[number] + own) < least + _ROUNDING:
            row, column = source.places[begin + number]
            away = _away(window, source, row, column, least)
            if away < least:
                best[0], best[1], least = row, column, away
    return best


@partial(jitted, fastmath={"reassoc", "contract"})
def _away(window: Array, source: _Source, row: int, column: int, least: Any) -> Any:
    """The squared distance of a window (width, width * C) from a source's, or what exceeds the least.

    A row at a time, in as many sums as the machine adds at once: its middle rows, which count most, come first.
    """
    width, values = source.roots.shape
    first = column * (values // width)
    total = np.float32(0)
    for i in source.rows:
        there, wanted, roots = source.padded[row + i, first : first + values], window[i], source.roots[i]
        apart = np.float32(0)
        for j in range(values):
            step = wanted[j] - there[j] * roots[j]
            apart += step * step
        total += apart
        if total >= least:
            return total
    return total
