"""Metamorphosis under texton masks as published (Tonietto and Walter, Texture Metamorphosis Driven by Texton Masks,
2005, section 3): pixel by pixel in raster order, after Wei and Levoy (2000).

Frame k is grown over frame k - 1, which is blocks of A at random before the first. At every pixel, the window of the
last mask finds its best match in either mask (steps 1 and 2); their values, mixed, are the new mask (3, 4). The window
of the frame, new above and old below, finds its best match in A among the pixels of the one value and in B among
those of the other (5, 6); their colors, mixed, are the new pixel (7). Windows are weighted by a Gaussian, and sources
and frames are periodic.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kwatra.base.compiled import jitted

Array = NDArray[np.float32]
Index = NDArray[np.int64]

_BLOCK = 8
_AXES = 48
_ROUNDING = 1e-6


class _Source(NamedTuple):
    """A source as it is searched: the first `ground` of its places have the mask's value 0, the others 1.

    padded (h + 2 reach, w + 2 reach, C); mask (h, w); taps (K, 2) and roots (K,) of their weights; axes (K * C, D), the
    principal ones of its windows; places (N, 2), their windows along the axes, (N, D), and half their squares, (N,).
    """

    padded: Array
    mask: Array
    taps: Index
    roots: Array
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
    taps, weights = _taps(width)
    middle = np.zeros((1, 2), np.int64)
    taps, weights = np.concatenate([middle, taps]), np.append(weights[:1], weights)  # it counts as its neighbors do
    return _searched(mask[..., None], np.zeros_like(mask), taps, weights)


def _source(image: Array, mask: Array, width: int) -> _Source:
    """A source's image (h, w, C), of which places with one value of the mask (h, w) are searched at a time."""
    return _searched(image, mask, *_taps(width))


def _searched(image: Array, mask: Array, taps: Index, weights: Array) -> _Source:
    width = 1 - 2 * int(taps[-1, 0])
    reach, roots = width // 2, np.sqrt(weights)
    padded = np.ascontiguousarray(np.pad(image, ((reach, reach), (reach, reach), (0, 0)), mode="wrap"))
    windows = np.concatenate([_windows(image[..., c], taps) * roots for c in range(image.shape[2])], 1)
    centered = windows - windows.mean(0)
    axes = np.ascontiguousarray(np.linalg.eigh(centered.T @ centered)[1][:, ::-1][:, :_AXES], np.float32)
    along = (windows @ axes).astype(np.float32)
    order = np.argsort(mask.reshape(-1), kind="stable")
    places, along = np.stack(np.unravel_index(order, mask.shape), 1), np.ascontiguousarray(along[order])
    half = np.square(along).sum(1) / 2
    return _Source(padded, mask, taps, roots, axes, places, along, half, int((mask == 0).sum()))


def _blocks(image: Array, mask: Array, shape: tuple[int, int], random: np.random.Generator) -> tuple[Array, Array]:
    """A frame and a mask of blocks of a source at random places."""
    y, x = np.indices(shape)
    rows, columns = (-(-side // _BLOCK) for side in shape)
    shifts = random.integers(0, image.shape[:2], (rows, columns, 2))[y // _BLOCK, x // _BLOCK]
    y, x = (y + shifts[..., 0]) % image.shape[0], (x + shifts[..., 1]) % image.shape[1]
    return image[y, x], mask[y, x]


def _taps(width: int) -> tuple[Index, Array]:
    """The offsets (K, 2) of a window's pixels but its middle, nearest first, and their Gaussian weights (K,)."""
    reach = width // 2
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)[:, ::-1]
    away = y**2 + x**2
    order = np.argsort(away, kind="stable")[1:]  # the top left corner last
    weights = np.exp(-away[order] / (2 * (width / 4) ** 2)).astype(np.float32)
    return np.stack([y, x], 1)[order], weights / weights.sum()


def _windows(mask: Array, offsets: Index) -> Array:
    """The periodic windows of a mask (H, W), as (H * W, K)."""
    rolled = [np.roll(mask, (-int(y), -int(x)), (0, 1)).reshape(-1) for y, x in offsets]
    return np.stack(rolled, 1)


@jitted
def _match(mask: Array, source: _Source, found: Index) -> None:
    """Steps 1 and 2: the places (H, W, 2) that windows of a mask (H, W, 1) match best, over those of the last frame."""
    for y in range(mask.shape[0]):
        for x in range(mask.shape[1]):
            found[y, x] = _nearest(_window(mask, y, x, source), source, 0.0, found, y, x)


@jitted
def _scan(
    frame: Array, share: float, a: _Source, value_a: Array, found_a: Index, b: _Source, value_b: Array, found_b: Index
) -> None:
    """Steps 5 to 7 over a frame (H, W, C), in place, and over the matches (H, W, 2) that the last frame found."""
    height, width, channels = frame.shape
    for y in range(height):
        for x in range(width):
            found_a[y, x] = _nearest(_window(frame, y, x, a), a, value_a[y, x], found_a, y, x)
            found_b[y, x] = _nearest(_window(frame, y, x, b), b, value_b[y, x], found_b, y, x)
            (row_a, column_a), (row_b, column_b) = found_a[y, x], found_b[y, x]
            for c in range(channels):
                one = a.padded[row_a - a.taps[-1, 0], column_a - a.taps[-1, 1], c]
                two = b.padded[row_b - b.taps[-1, 0], column_b - b.taps[-1, 1], c]
                frame[y, x, c] = share * one + (1 - share) * two


@jitted
def _window(frame: Array, y: int, x: int, source: _Source) -> Array:
    """The weighted window (K * C,) of a frame at (y, x), channel by channel."""
    height, width, channels = frame.shape
    count = len(source.roots)
    window = np.empty(count * channels, np.float32)
    for k in range(count):
        row, column = (y + source.taps[k, 0]) % height, (x + source.taps[k, 1]) % width
        for c in range(channels):
            window[c * count + k] = frame[row, column, c] * source.roots[k]
    return window


@jitted
def _nearest(window: Array, source: _Source, wanted: float, found: Index, y: int, x: int) -> Index:
    """The place (2,) of a source, of the wanted mask value, whose window is nearest to a window (K * C,).

    It is exact. The distance along the principal axes is never more than the whole one, so only places are compared
    whole that are near along these; the match of the last frame, those above and to the left continued, and the
    nearest along the axes are a small distance to begin with.
    """
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
    along = np.dot(window, source.axes)
    begin, end = (0, source.ground) if wanted == 0 else (source.ground, len(source.places))
    if begin == end:
        return best
    half = source.half[begin:end] - np.dot(source.along[begin:end], along)
    own = np.dot(along, along) / 2
    row, column = source.places[begin + half.argmin()]
    away = _away(window, source, row, column, least)
    if away < least:
        best[0], best[1], least = row, column, away
    for number in range(end - begin):
        if 2 * (half[number] + own) < least + _ROUNDING:
            row, column = source.places[begin + number]
            away = _away(window, source, row, column, least)
            if away < least:
                best[0], best[1], least = row, column, away
    return best


@jitted
def _away(window: Array, source: _Source, row: int, column: int, least: Any) -> Any:
    """The squared distance of a window (K * C,) from a source's, or what exceeds the least."""
    reach, count, channels = -source.taps[-1, 0], len(source.roots), source.padded.shape[2]
    total = np.float32(0)
    for k in range(count):
        for c in range(channels):
            there = source.padded[row + source.taps[k, 0] + reach, column + source.taps[k, 1] + reach, c]
            apart = window[c * count + k] - there * source.roots[k]
            total += apart * apart
        if total >= least:
            return total
    return total
