"""Ways in which the ground of a texture may differ from its elements: darker, lighter, nearer to some color."""

from collections.abc import Iterator

import numpy as np
from scipy import ndimage

from kwatra.elements.parting import Array

SMOOTHING = 0.7
"""Brightness is smoothed by so many pixels: noise makes no ground."""

COLORFUL = 0.1
"""Pixels are told by their color, too, where more than this of its variance lies off one line: else brightness says it,
and in smooth gray noise what is of middle brightness would be ground. Of 51 photographs 4 have as much, of mosaics made
in code all but those of gray stones, which have .06."""

SHARPER, BINS, COLORS = 0.4, 6, 6
"""Colors are smoothed by so many pixels, as thin mortar takes in its rims; of the colors of so many bins along each
channel, so many that are the most frequent are tried as the ground's. In 24 mosaics of random colors the ground that is
found and the true one share .72 of their pixels (F1) with these alone, .71 to .73 with 5 and 8 bins and up to 14
colors, .57 where brightness alone is looked at."""

THIN, THIN_COLORS, WIDEST = ((0.125, 0.25), (0.25, 0.15)), 4, 1.5
"""What is unlike its mean over so many sizes of an element around, at least so many px, most of all by so much of the
picture, is thin; so many of its frequent colors are tried, too. Of 24 mosaics of random colors the ground that is found
and the true one share .65 or more of their pixels (F1), in two .47 without: some stones are taken for it then."""

ROUNDING = 1e-9
"""Brightness that differs by no more is one; it is 0 to 1."""

NARROW = 0.25
"""Joints are up to twice so many sizes of an element wide; with .1 and .15 stones are parted as well."""

RARE = "rare"
"""With this begin kinds of splits by likeness to a color of what is thin."""

BRIGHTNESS = ("dark", "light")
"""Kinds of splits that find ground of several colors, too; by likeness to a color it is found where it hides seams."""


def contrasts(colors: Array, inside: Array, size: float) -> Iterator[tuple[str, Array]]:
    """What is less on the ground, (*S), and of which kind it is: how dark a pixel is, how light, how unlike a color.

    colors (C, *S), of which those `inside` (*S) count; size: that of an element, px.
    """
    bright = smoothed(colors.mean(0), inside, SMOOTHING)
    around = smoothed(bright, inside, max(size, 4.0))
    yield from (("dark", bright), ("light", -bright), ("dark", bright - around), ("light", around - bright))
    if not _colorful(colors[:, inside]):
        return
    sharper = np.stack([smoothed(channel, inside, SHARPER) for channel in colors])
    for number, color in enumerate(frequent(sharper[:, inside], COLORS)):
        yield str(number), _unlike(sharper, color[:, None, None])
    for number, color in enumerate(_of_thin(sharper, inside, size)):
        yield f"{RARE} {number}", _unlike(sharper, color[:, None, None])


def against_around(colors: Array, inside: Array, size: float) -> Iterator[Array]:
    """What is less on joints, (*S), that are darker than what is on both sides of them, and on lighter ones.

    That is how much is left of brightness when narrow dark valleys are filled (a closing; Serra 1982).
    """
    bright, wide = smoothed(colors.mean(0), inside, SHARPER), 2 * max(round(NARROW * size), 2) + 1
    for values in (bright, -bright):
        values = np.where(inside, values, values[inside].min())
        yield values - ndimage.grey_closing(values, wide)


def _colorful(colors: Array) -> bool:
    """Whether colors (C, N) lie along more than one line."""
    apart = colors - colors.mean(1, keepdims=True)
    spread = np.linalg.eigvalsh(np.einsum("ik,jk->ij", apart, apart))
    return bool(spread[:-1].sum() > COLORFUL * spread.sum())


def _of_thin(colors: Array, inside: Array, size: float) -> Iterator[Array]:
    """Frequent colors (C,) of what is thin and unlike what is around."""
    for around, share in THIN:
        wide = np.stack([smoothed(channel, inside, max(around * size, WIDEST)) for channel in colors])
        off = _unlike(colors, wide)
        yield from frequent(colors[:, inside & (off >= np.quantile(off[inside], 1 - share))], THIN_COLORS)


def _unlike(colors: Array, other: Array) -> Array:
    """How far colors (C, *S) are from others."""
    unlike: Array = np.sqrt(np.square(colors - other).sum(0))
    return unlike


def frequent(colors: Array, count: int) -> list[Array]:
    """So many colors (C,) near which most of some (C, N) lie."""
    low, spread = colors.min(1, keepdims=True), np.ptp(colors, 1)[:, None]
    bins = ((colors - low) / np.maximum(spread, ROUNDING) * BINS).astype(int).clip(max=BINS - 1)
    number = np.zeros(bins.shape[1], dtype=int)
    for channel in bins:  # numbered anew each time, so that any number of channels will do
        number = np.unique(BINS * number + channel, return_inverse=True)[1]
    often = np.bincount(number)
    most = np.argsort(-often, kind="stable")[:count]
    return [colors[:, number == each].mean(1) for each in most]


def smoothed(values: Array, inside: Array, sigma: float) -> Array:
    """Values (*S) blurred, of what is `inside` alone."""
    if inside.all():
        smooth: Array = ndimage.gaussian_filter(values, sigma)
        return smooth
    share = ndimage.gaussian_filter(inside.astype(float), sigma)
    part: Array = ndimage.gaussian_filter(np.where(inside, values, 0.0), sigma) / np.maximum(share, 1e-9)
    return part


def two_classes(values: Array) -> float:
    """The value that splits values into the two classes whose means differ most (Otsu 1979)."""
    count, borders = np.histogram(values, 128)
    middle = (borders[1:] + borders[:-1]) / 2
    below, summed = np.cumsum(count)[:-1], np.cumsum(count * middle)[:-1]
    rest = values.size - below
    between = ((count * middle).sum() * below / values.size - summed) ** 2 / np.maximum(below * rest, 1)
    return float(borders[1 + int(np.argmax(between))])
