"""Elements that thin lines part: stones without mortar, bricks, cracked mud, veined glass.

Such lines are too thin to be ground of one color, and too faint to be told pixel by pixel from grain. But along them
everything is darker than on both sides, or lighter. So how strong a line leads through each pixel is measured by strips
of many directions, the picture is parted along what is strongest (a watershed; Meyer 1994, "Topographic distance and
watershed lines"), and parts grow together until all that is between them is strong. It is a net of lines where these
borders are lines all along, where no strong line ends within a part, where within parts nothing is as strong, and
where parts are about as large as one another.
What the picture's border leaves of a part is one, too, however small, but tells nothing of the net.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch
from scipy import fft, ndimage

from kwatra.base import continued
from kwatra.elements.contrast import ROUNDING, smoothed
from kwatra.elements.merging import merged
from kwatra.elements.parting import Array, at_edge, touching, usual_area
from kwatra.elements.splits import MANY, SPECK, Ground, Picture, depth_beside

ACROSS, ALONG, DIRECTIONS = 1.6, 4.5, 8
"""Strips are Gaussian, with these standard deviations in pixels, of so many directions. Of stones made in code, 26 and
40 px, parted by lines of 3 px, with grain of up to the lines' own contrast, the lines that are found and the true ones
share .955 of their pixels (F1); .905 with 1 and 4, .951 with 2 and 5, .954 with 12 directions."""

BESIDE = 3
"""How far the strips beside a line are from its own, in standard deviations across. Not tuned."""

STRONG = 0.97
"""Lines are measured by this quantile of strengths."""

SURE = 0.7
"""Parts that a net leaves are elements so surely. Of photographs and game textures bricks, stones, pavers and weaves
have .74 and more; canyons and enamel, whose lines wander, up to .66 and are torn along them, bark and twill 0."""

GATE, SEEN = 0.4, 1.8
"""A net is only looked for where what is stronger than GATE of that strength is SEEN times its own deviation from what
is not beside it, as of APART. Of photographs and game textures with a net all are, by 1.87 and more; three quarters of
the others are not, and need not be parted."""

BORDERS = (0.3, 0.4, 0.5, 0.6)
"""Shares of that strength that borders between parts have at least; the clearest are taken."""

NEAR, THIN = 3, 0.65
"""A net is thin where at most so much of the picture lies within so many pixels of it; so close to the picture's border
lines are not looked at. With .5 some lines between the stones of 26 px above are left out, with .6 between pavers of 17
px in a photograph and bricks of 20 px made in code, with .7 bark has a net."""

NARROWEST = 2 * NEAR / (1 - math.sqrt(1 - THIN))
"""Elements that a thin net parts are so many pixels wide at least: a picture that has no room for some has no net."""

UNCLEAR = 0.5
"""A net is no less clear than this. That of the stones above is .05 to .47 if their grain is not as strong as lines, of
mud, cracked, .09, of bricks of 18 to 48 px made in code .08 to .4; of 52 photographs fourteen have .02 to .45, all
others .59 and more."""

APART, UNEVEN, SMOOTH = 1.95, 0.44, 1.0
"""Colors of a net, smoothed by SMOOTH pixels, are APART times their own deviation from those of parts; its strength
deviates by UNEVEN of its mean at most. Stones made in code, mud, a wall and rocks have 1.99 and more, but for two of
24 of the stones, and .43 and less. Between radishes, tomatoes and gravel, which lie on each other, it is 1.3, 1.7 and
1.8 to 2.0, and seams along that are seen (gravel scores .067 for .056); tiles of a roof have .45, and are shown twice
side by side. Of the fourteen photographs above walls, pavers, rocks and pebbles are left, and print."""

LONG = 1.8
"""Parts are long that are so many times as long as wide. Bricks made in code are 2 times, stones and mud 1.4 times at
most."""

AS_CLEAR = 1.1
"""Of nets that are so much less clear than the clearest at most the one with the fewest lines is taken. Not tuned."""

INNER = 0.95
"""What is strong within parts is this quantile there."""


def nets_of_lines(picture: Picture) -> Iterator[Ground]:
    """Ground that is a net of thin lines, darker than elements or lighter, two pixels wide along each.

    Memory is that of some arrays of a picture's size.
    """
    if np.count_nonzero(picture.inside) < SURE * MANY * NARROWEST**2:
        return
    colors, owner = (torch.from_numpy(of) for of in (picture.colors.mean(0, keepdims=True), picture.owner))
    bright = continued(colors, owner)[0].numpy()
    smooth = np.stack([smoothed(channel, picture.inside, SMOOTH) for channel in picture.colors])
    for values, strength in zip((bright, -bright), line_strength(bright), strict=True):
        high = float(np.quantile(strength[picture.inside], STRONG))
        lines = (strength > GATE * high) & picture.inside
        seen = high > 0 and _apart(lines, smooth, picture.inside, 1) >= SEEN
        net = _net(strength, picture.inside, high) if seen else None
        if net is None:
            continue
        outline = _outline(net.parts)
        if _alike(outline, strength, smooth, picture.inside) and _parts_elements(outline, picture):
            yield _ground(net.with_tips(strength, picture.inside), values, picture.inside)


def line_strength(bright: Array) -> tuple[Array, Array]:
    """How much darker than what is on both sides the darkest strip through each pixel is, and how much lighter.

    bright (H, W); both are (H, W), 0 where no strip is darker, or lighter, than both sides.
    """
    away = BESIDE * ACROSS
    rim = int(np.ceil(4 * ALONG + away))
    height, width = (fft.next_fast_len(size + 2 * rim, real=True) for size in bright.shape)
    beyond = [(rim, whole - size - rim) for whole, size in zip((height, width), bright.shape, strict=True)]
    transformed = fft.rfft2(np.pad(bright, beyond, mode="reflect"))
    down, right = 2 * np.pi * fft.fftfreq(height)[:, None], 2 * np.pi * fft.rfftfreq(width)
    dark, light = np.zeros((2, *bright.shape))
    for angle in np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        cos, sin = np.cos(angle), np.sin(angle)
        blur = np.square(ALONG * (sin * down + cos * right)) + np.square(ACROSS * (cos * down - sin * right))
        strips = fft.irfft2(np.exp(-0.5 * blur) * transformed, (height, width))
        steps = ((round(step * cos), round(-step * sin)) for step in (0.0, -away, away))
        here, before, behind = (
            strips[rim + y : rim + y + bright.shape[0], rim + x : rim + x + bright.shape[1]] for y, x in steps
        )
        np.maximum(dark, np.minimum(before, behind) - here, out=dark)
        np.maximum(light, here - np.maximum(before, behind), out=light)
    return dark, light


class _Net(NamedTuple):
    """A net of lines: the parts (*S), by number, that it leaves, and the pieces that these grew together from.

    least: the strength of borders between them; speck: what smaller pieces were no parts, px^2.
    """

    parts: Array
    pieces: Array
    least: float
    speck: float

    @classmethod
    def of(cls, pieces: Array, strength: Array, inside: Array, least: float) -> "_Net":
        speck = SPECK * usual_area(np.bincount(pieces[inside]))
        return cls(merged(pieces, strength, least, speck), pieces, least, speck)

    def with_tips(self, strength: Array, inside: Array) -> Array:
        """The parts, and what the picture's border leaves of others, however little."""
        return merged(self.pieces, strength, self.least, self.speck, at_edge(self.pieces, inside).tolist())


def _net(strength: Array, inside: Array, high: float) -> _Net | None:
    """The clearest net of lines; None if there is no clear one."""
    from skimage.segmentation import watershed  # takes a tenth of a second; few pictures need it

    pieces, tried = watershed(strength, mask=inside), []
    for share in BORDERS:
        pieces = merged(pieces, strength, share * high)
        net = _Net.of(pieces, strength, inside, share * high)
        tried.append((_unclear(net.parts, strength, inside, share * high), net))
    least = min(unclear for unclear, _ in tried)
    return [net for unclear, net in tried if unclear <= AS_CLEAR * least][-1] if least <= UNCLEAR else None


def _unclear(parts: Array, strength: Array, inside: Array, strong: float) -> float:
    """How unclear a net is: what of it is not strong, what is strong and not of it, and how strong its parts are."""
    net = _outline(parts)
    near = ndimage.binary_dilation(net, iterations=NEAR) & inside
    seen = ndimage.binary_erosion(inside, iterations=NEAR)  # a line along the border parts nothing
    rest, lines = seen & ~near, np.where(seen & (strength > strong), strength, 0)
    thin = np.count_nonzero(near) <= THIN * np.count_nonzero(inside)
    if not (thin and net.any() and rest.any() and lines.any()):
        return np.inf
    lost = lines[rest].sum() / lines.sum()
    weak = 1 - (ndimage.maximum_filter(strength, 3)[net] > strong).mean()
    within = np.quantile(strength[rest], INNER) / strength[net].mean()
    return float(lost + weak + within)


def _outline(parts: Array) -> Array:
    """The pixels (H, W) on both sides of where parts meet; 0 is no part."""
    met = np.zeros(parts.shape, bool)
    for index, before, meet in touching(parts):
        met[index] |= meet
        met[before] |= meet
    return met


def _alike(net: Array, strength: Array, smooth: Array, inside: Array) -> bool:
    """Whether a net (*S) is of one color, other than that of the parts between, and as strong all along."""
    strong = ndimage.maximum_filter(strength, 3)[net]
    return bool(_apart(net, smooth, inside, NEAR) >= APART and strong.std() <= UNEVEN * strong.mean())


def _apart(lines: Array, smooth: Array, inside: Array, near: int) -> float:
    """How far smooth colors (C, *S) of lines are from those not so near, px, on the mean, in their own deviation."""
    rest = inside & ~ndimage.binary_dilation(lines, iterations=near)
    if not (rest.any() and lines.any()):
        return 0.0
    apart = np.square(smooth[:, rest].mean(1) - smooth[:, lines].mean(1)).sum()
    return float(np.sqrt(apart / max(smooth[:, lines].var(1).sum(), ROUNDING)))


def _parts_elements(net: Array, picture: Picture) -> bool:
    """Whether what a net (*S) parts is about as large as one another, so that it is elements."""
    return picture.by_itself("lines", net & picture.inside)[0].sure >= SURE


def _long(parts: Array) -> bool:
    """Whether most parts are long."""
    from skimage.measure import regionprops_table

    told = ("area", "axis_major_length", "axis_minor_length")
    area, longest, widest = (np.asarray(each) for each in regionprops_table(parts, properties=told).values())
    long = longest > LONG * widest
    return bool(area[long].sum() > area.sum() / 2)


def _ground(parts: Array, values: Array, inside: Array) -> Ground:
    """The net between parts, moved to where values (*S) are least."""
    from skimage.segmentation import watershed

    away = ndimage.distance_transform_edt(~_outline(parts))
    deepest = ndimage.maximum(away, parts, np.arange(parts.max() + 1))
    kernels = np.where(away > np.minimum(deepest / 2, NEAR)[parts], parts, 0)
    found = watershed(-smoothed(values, inside, SMOOTH), kernels, mask=inside)
    size = float(np.sqrt(usual_area(np.bincount(found[inside]))))
    return Ground(depth_beside(_outline(found), size), 1.0, 1.0, size, _long(parts))
