"""How large the elements of a texture are: stones, discs, cells, letters, blobs.

Elements of like colors are told apart by the gaps between them, elements of one brightness by their colors, elements
without gaps by their edges. So two curves are read: the autocorrelation of the colors, and that of the strength of
edges, each averaged over all directions. Where elements lie side by side the curve falls, dips, and rises again to a
ring one element further on; its lag is their distance, an element with its share of the gap around it.
"""

from collections.abc import Iterator
from itertools import accumulate, takewhile

import torch
from torch import Tensor

from kwatra.elements.correlation import Correlation, of_colors, of_edges
from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar

SMALLEST = 2.0
"""Size, in pixels, of the elements of a texture without any."""

LOOKED_AT = 2**19
"""A larger image is halved for finding the size of its elements until it has so many pixels: of twelve million it would
take 40 s, and blocks are laid of no more (`kwatra.levels`)."""

ALTERNATING = -0.27
"""At this correlation elements and what lies between them trade places: cells and stripes, of which neither is ground.

Made checkerboards and stripes reach -0.28 and less, discs on a lattice -0.25; photographs of textures hardly -0.2.
"""

UNLIKE = 0.1
"""Two pixels with this correlation or less do not belong to one element: a convention."""

RISE, FALL = 0.06, 0.03
"""A ring stands out by so much from the dip before it and from what follows; set on made textures and noise."""

CLEAR = 0.6
"""A ring counts if it rises this share of the highest: the stems within letters make a small one. Of 18 pages of made
letters 15 are measured within 15%, also with .75 and .9, and 13 with .3 and .45; of 52 photographs one, bricks, has
another size with .75."""


@kept
def element_size(exemplar: Exemplar) -> float:
    """Size in pixels of the elements of an exemplar's texture, at least 2: an element with its share of the gap.

    Where two kinds of elements alternate (a checkerboard, equal stripes) it is the lag at which they trade places, a
    cell's side. Otherwise it is the lag of the first ring, in colors or else in edges. Where there is none (noise,
    grass, patches), it is twice the lag at which colors have become unlike: a blob and the space beside it. Elements
    up to a third of the smaller side are found. Of a video, all frames are looked at; what nobody owns never is. An
    image of more than `LOOKED_AT` pixels is looked at coarser.
    """
    seen, factor = exemplar.halved_to(LOOKED_AT)
    if factor > 1:
        return factor * element_size(seen)
    side = min(max(picture.shape[axis] for picture in exemplar.pictures()) for axis in (-2, -1))
    color = radial(of_colors(exemplar).within(side // 2))
    if float(color[0]) == 0:
        return SMALLEST
    dip = _first_dip(color)
    if dip is not None and color[dip] < ALTERNATING:
        return max(_vertex(-color, dip), SMALLEST)
    edge = radial(of_edges(exemplar).within(side // 2))
    for curve in (color, edge):
        ring = _ring(curve, side)
        if ring is not None:
            return max(ring, SMALLEST)
    return max(2 * unlike(color), SMALLEST)


def radial(correlation: Correlation) -> Tensor:
    """Mean correlation (R + 1,) over all directions, by the lag's length; lags count by what overlaps at them."""
    down, right = (torch.arange(-r, r + 1) for r in correlation.reach)
    length = (down[:, None].square() + right.square()).double().sqrt()
    return correlation.mean_by(length, min(correlation.reach) + 1)[0]


def _ring(curve: Tensor, side: int) -> float | None:
    """The lag of the first clear peak, None without one.

    The larger the blobs of a picture, the fewer they are, and the larger the peaks that chance makes.
    """
    rise = max(RISE, unlike(curve) / side)
    rings = [(lag, up) for lag, up, down in _peaks(curve.tolist()) if lag <= side / 3 and up >= rise and down >= FALL]
    highest = max((up for _, up in rings), default=0.0)
    return next((_vertex(curve, lag) for lag, up in rings if up >= CLEAR * highest), None)


def _peaks(values: list[float]) -> Iterator[tuple[int, float, float]]:
    """Each peak's lag, how far it rises from the lowest value before it, and falls before a higher one follows."""
    lowest = list(accumulate(values, min))
    for lag in range(1, len(values) - 1):
        if values[lag - 1] <= values[lag] > values[lag + 1]:
            below = takewhile(values[lag].__ge__, values[lag:])
            yield lag, values[lag] - lowest[lag], values[lag] - min(below)


def _first_dip(curve: Tensor) -> int | None:
    """The lag of the first minimum below 0; the curve's last lag is none."""
    dips = (curve[1:-1] < curve[:-2]) & (curve[1:-1] <= curve[2:]) & (curve[1:-1] < 0)
    found = dips.nonzero()
    return int(found[0]) + 1 if len(found) else None


def _vertex(curve: Tensor, lag: int) -> float:
    """The lag of the parabola's vertex through a peak and its neighbors."""
    before, peak, after = curve[lag - 1 : lag + 2].tolist()
    bend = before - 2 * peak + after
    return lag + (0.5 * (before - after) / bend if bend else 0.0)


def unlike(curve: Tensor) -> float:
    """The lag at which the curve falls to `UNLIKE`, between samples; its length where it does not."""
    below = (curve <= UNLIKE).nonzero()
    if not len(below):
        return float(len(curve))
    lag = int(below[0])
    if lag == 0:
        return 0.0
    high, low = curve[lag - 1 : lag + 1].tolist()
    return lag - 1 + (high - UNLIKE) / (high - low)
