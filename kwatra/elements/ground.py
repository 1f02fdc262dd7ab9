"""The ground that a texture's elements lie on: mortar, gaps, cloth, paper.

Ground is darker than elements, or lighter, and hangs together; what it leaves are parts about as large as an element.
So brightness, as it is and against its surroundings, is split at several values, and the split is taken that says so
most surely (compare Matas et al. 2002, "Robust wide baseline stereo from maximally stable extremal regions"). In a
picture of many colors, of which some are as bright as the ground, likeness to some of its colors is split as well. Of
splits that say it as surely those come first that are of one color, and of these the one with least ground, since the
shaded rim of an element is not its gap. Where elements are cut out, what is transparent is tried as well. Specks on the
ground are ground, but for what a hole, or the border, leaves of an element.

Where colors of such ground are mixed, and those of elements, too, it is sought against what is right around it: joints
between stones, shaded, and between dark stones darker than the joints of light ones. Where that finds none, a net of
thin lines is sought (`kwatra.elements.lines`), and then ground that is a texture of its own, which elements are
scattered on (`kwatra.elements.scattered`).
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements.contrast import BRIGHTNESS, ROUNDING, against_around, contrasts, two_classes
from kwatra.elements.kept import kept
from kwatra.elements.lines import nets_of_lines
from kwatra.elements.parting import Array, at_edge, between_parts, meeting
from kwatra.elements.scattered import unlike_most
from kwatra.elements.size import element_size
from kwatra.elements.splits import SMALL, Ground, Picture, Split, cleaned, depth_beside
from kwatra.exemplar import Exemplar

SPLITS = (0.08, 0.12, 0.17, 0.23, 0.3, 0.4)
"""Shares of the pixels that are tried as ground, beside the one at which two classes differ most (Otsu)."""

HALVED, ONE = 4, 0.03
"""Where none of these is plain, so many more are tried between two of which the one with less ground is plain and the
one with more as sure as any, by halves; of these such count whose colors vary by ONE of the picture's at most. Of walls
made in code thin mortar of one color is .19, varies by .006 and hangs together; .17 does not, and .21 holds rims of
bricks. In four photographs what is found so varies by .06 and more, and with seams along it they score .066 for
.060."""


AS_SURE = 0.95
"""What is this share of the surest is as sure; with .9 and 1 stills of four textures with elements score the same."""

OPAQUE = 0.5
"""Alpha from which on a pixel is no ground: halfway, not tuned."""

JOINTS, SURE = (0.23, 0.3), 0.8
"""Shares of the pixels that are tried as joints, and how surely they are some at least. Elements of stones of 16 to 26
px and many brightnesses are parted by joints that are found so but for .02 of them; by brightness as it is .03 to .5
grow together."""

APART, ALIKE = 0.25, 0.18
"""Where so much of the variance of colors lies between elements, each with its share of the joints, cuts through them
are seen, and seams along joints are hidden; with ALIKE they are not. In stones made in code .27 and more does, in
photographs with joints .13 at most."""

LITTLE, PURE, CERTAIN = 0.1, 0.1, 0.95
"""Where ground hides seams no better than LITTLE, such is sought whose colors vary by PURE of the picture's at most and
that is as surely ground for elements of the size that it leaves. Of 52 photographs none has such; pavers vary by .18,
and rocks by .16 and are as sure as .87, and seams along them are seen."""

HALF, AWAY, MOST = 0.5, (2.0, 2.5, 3.0, 4.0), 0.45
"""Where ground hides seams no better than HALF, such is sought that is a texture of its own: what is no further from it
than AWAY times as far as half of the picture is. It is as CERTAIN, and is so much of the picture.

Of made pebbles on sand, leaves on soil and shells on sand, 20 and 28 px in 128x128, .24 are cut without it, .04 with
it (256x256, two seeds that were not looked at before); of sweets on wood, buttons on checked cloth, berries among
leaves and bolts on brushed metal, on which nothing was set, .13 and .04. Of 52 photographs none has such; with .95 in
place of HALF print on a page has, whose words then stay whole, but copies are .34 of it, not .23."""

EVEN = 0.15
"""Such ground is even: its colors, averaged over a quarter of an element's size, vary by no more of the picture's. That
of 59 made textures does by .11 at most, by .04 in the mean; of flat stones of four colors, of which two may be half of
the picture and hang together, by .20 and more."""


class _Way(NamedTuple):
    """Values (*S) that are less on the ground, of some kind, and splits at some of them, least ground first."""

    kind: str
    values: Array
    at: Sequence[float]
    splits: Sequence[Split]


@kept
def find_ground(exemplar: Exemplar) -> Ground:
    """The ground of an exemplar of still images. Textures without one have a `sure` of about 0."""
    picture, size = Picture(exemplar), element_size(exemplar)
    ways = [_way(kind, values, picture, size) for kind, values in contrasts(picture.colors, picture.inside, size)]
    tried = [split for way in ways for split in way.splits]
    if exemplar.alpha is not None:  # as it is: what is dark when smoothed holds opaque rims of elements
        tried.insert(0, picture.judged("dark", (exemplar.alpha < OPAQUE).numpy(), size))
    tried = [split for split in tried if split.plain > 0 or split.kind in BRIGHTNESS]
    surest = max(split.whole for split in tried)
    plain = [split for split in tried if split.plain > 0 and split.whole >= AS_SURE * surest]
    plain = plain or [split for way in ways for split in _between(way, surest, picture, size)]
    found = _best(plain, lambda split: split.likely) if plain else _best(tried, lambda split: split.sure)
    told = [picture.told(found, surest, size)]
    if found.plain < 1:
        told += _joints(picture, size)
    if max(one.hides for one in told) < LITTLE:
        told += [one for way in ways for one in _of_own_size(way, picture)]
    if max(one.hides for one in told) < HALF:
        told += nets_of_lines(picture)
    if max(one.hides for one in told) < HALF:
        told += _scattered(picture)
    return max(told, key=lambda one: one.hides)


def _of_own_size(way: _Way, picture: Picture) -> Iterator[Ground]:
    """Ground of one color that leaves parts that say for themselves how large an element is.

    Where elements are made up of others, as buttons of rings, the size that is seen first may be theirs.
    """
    for most in way.at:
        split = (way.values <= most) & picture.inside
        if 0 < picture.variance.share(split) <= PURE:
            found, size = picture.by_itself(way.kind, split)
            if found.sure >= CERTAIN:
                yield picture.told(found, found.sure, size)


def _scattered(picture: Picture) -> list[Ground]:
    """Ground that is a texture of its own and most of the picture, with elements scattered on it; none is none.

    Of what is as surely such that with the least ground: seams then keep away from elements.
    """
    values, least = unlike_most(picture.colors, picture.inside), MOST * np.count_nonzero(picture.inside)
    for far in AWAY:
        found, size = picture.by_itself("scattered", (values <= far) & picture.inside)
        if found.sure < CERTAIN or np.count_nonzero(found.ground) < least:
            continue
        if picture.uneven(found.ground, size / 4) <= EVEN:
            return [Ground(depth_beside(found.ground, size), found.sure, 1.0, size)]
    return []


def _joints(picture: Picture, size: float) -> Iterator[Ground]:
    """Joints between elements that differ in color, told by what is right around them, however they vary.

    Rims of elements are taken for joints as well, so the ground is only the middle of what is found.
    """
    colors, inside = picture.colors, picture.inside
    for values in against_around(colors, inside, size):
        for most in np.quantile(values[inside], JOINTS):
            split = (values <= most) & inside
            ground, sure, _ = cleaned(split, picture.owner, size)
            if sure < SURE:
                continue
            specks, _ = ndimage.label(ground & ~split)
            ground &= ~np.isin(specks, at_edge(specks, inside))
            parts = meeting(ground, values, inside, SMALL * size**2)
            differ = (between_parts(colors, parts, inside) - ALIKE) / (APART - ALIKE)
            lines = (parts == 0) & inside
            middle = lines | (ground & ndimage.binary_dilation(lines))
            yield Ground(depth_beside(middle, size), sure, min(max(differ, 0.0), 1.0), size)


def _way(kind: str, values: Array, picture: Picture, size: float) -> _Way:
    """Splits at several values; where all are one there is ground alone."""
    known = values[picture.inside]
    if np.ptp(known) <= ROUNDING:
        return _Way(kind, values, [known.max()], [picture.judged(kind, picture.inside, size)])
    at = sorted((two_classes(known), *np.quantile(known, SPLITS)))
    return _Way(kind, values, at, [picture.judged(kind, values <= most, size) for most in at])


def _between(way: _Way, surest: float, picture: Picture, size: float) -> Iterator[Split]:
    """Splits of one color, as sure as the surest, between one of too little ground for that and one of too much."""
    for (less, few), (more, many) in pairwise(zip(way.at, way.splits, strict=True)):
        if few.plain > 0 and few.whole < AS_SURE * surest <= many.whole and many.plain == 0:
            for _ in range(HALVED):
                most = (less + more) / 2
                split = picture.judged(way.kind, way.values <= most, size)
                sure = split.whole >= AS_SURE * surest
                less, more = (less, most) if sure else (most, more)
                if sure and split.varied <= ONE:
                    yield split


def _best(splits: Sequence[Split], worth: Callable[[Split], float]) -> Split:
    """The split that is worth most; of those of its kind that are worth about as much the one with least ground."""
    best = max(splits, key=worth)
    alike = [split for split in splits if split.kind == best.kind and worth(split) >= AS_SURE * worth(best)]
    return min(alike, key=lambda split: np.count_nonzero(split.ground))
