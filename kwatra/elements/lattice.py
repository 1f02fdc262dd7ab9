"""The lattice of a near-regular texture: two vectors by which it may be moved onto itself.

Such moves are peaks of the autocorrelation of colors, and any two of them span a lattice. Of all pairs of strong peaks
those are best at whose lattice points the correlation is highest; of equals the finest is the texture's. Its vectors
are then fitted to the peaks at its points, near ones first, since what is regular here need not be so far away.
Compare Liu, Collins and Tsin 2004, "A computational model for periodic pattern perception based on frieze and
wallpaper groups", section 3.
"""

import math
from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import running, total
from kwatra.elements.correlation import Correlation, of_colors, of_edges
from kwatra.elements.kept import kept
from kwatra.elements.size import radial, unlike
from kwatra.exemplar import Exemplar

STRONGEST = 24
"""Vectors are sought among so many peaks: a bound on time."""

NEAR = 2
"""A lattice is judged at its points up to so many vectors away along each."""

SHORTEST = 3.0
"""Vectors are at least so many pixels long, and stand on each other at 30 degrees or more."""

LONGEST = 8.0
"""One vector is at most so many times the other: strokes that repeat along a line make no lattice. The same is found of
60 made lattices and 23 photographs with 16; with no limit lines of text are one."""

AS_GOOD = 0.9
"""The finest lattice with this share of the highest correlation is taken: its multiples fit as well as it does.

Of 60 made lattices, with jitter up to a tenth of a vector, 56 are found right, 52 with .95 and 57 with .8; that loses
two of 23 photographs, walls of bricks, and .95 takes three roof tiles for one."""

REGULAR = 0.25
"""Least mean correlation at a lattice's points; set, as the next three, on made lattices with jitter and on noise."""

REGULAR_EDGES = 0.55
"""The same for edges, which are alike in more directions than colors are."""

BETWEEN = 0.05
"""Half-way to a lattice's points the correlation is lower by this at least: stripes have no lattice."""

PERIODIC = 0.93
"""So regular is what repeats but for noise: no block of it need be out of step. Set on made pictures of 1.2 to 3
periods, which have .94 and more; a twill of .93 scores .063 by gaps, .067 in step alone. Bark has .86, rocks .81."""

CHANCE = 3.0
"""A mean correlation is trusted less so many standard deviations of what chance makes."""


@dataclass(frozen=True)
class Lattice:
    """The vectors by which a texture repeats.

    vectors (2, 2) float64, each (down, right) in pixels: the two shortest. regularity: 0 to 1, the mean correlation of
    the texture with itself moved by lattice vectors; 1 is periodic.
    """

    vectors: Tensor
    regularity: float

    @property
    def shortest(self) -> float:
        """The length of the shorter vector, in pixels."""
        return float(self.vectors.norm(dim=1).min())

    @property
    def periodic(self) -> bool:
        """Whether the texture repeats but for noise."""
        return self.regularity >= PERIODIC

    def coarser(self, factor: float) -> "Lattice":
        """The same where pixels are a factor coarser."""
        return replace(self, vectors=self.vectors / factor)

    def rest(self, offsets: Tensor) -> Tensor:
        """What is left (2, ...) of offsets (2, ...) in pixels after the nearest lattice point; 0 is in step."""
        from kwatra.elements.loops import take_nearest

        rest = offsets.double().reshape(2, -1).clone()
        basis = self.vectors.T.contiguous()
        take_nearest(rest.shape[1], basis, torch.linalg.inv(basis), rest)
        return rest.view(offsets.shape)


@kept
def find_lattice(exemplar: Exemplar) -> Lattice | None:
    """The lattice of an exemplar's texture, None where it has none: noise, stripes, scattered things.

    It is sought in the colors, and where these have none (tiles of many colors) in the edges. It is found from one and
    a half periods on, whatever the angle; the more periods, the finer its vectors.
    """
    color = of_colors(exemplar).trusted()
    blob = _blob(color)
    lattice = _lattice(color, blob, REGULAR)
    if lattice is not None:
        return lattice
    # edges are thin, but there are no more of them than there are elements
    return _lattice(of_edges(exemplar).trusted(), blob, REGULAR_EDGES)


def _lattice(found: Correlation, noise: float, least: float) -> Lattice | None:
    if float(found.value[found.reach]) == 0:
        return None
    vectors = _finest(found, _strongest(found, noise), noise)
    if vectors is None:
        return None
    vectors = reduced(_fitted(found, vectors))
    means, spreads = _means(found, vectors[None], max(noise, _chance(found, vectors)))
    regularity = float(means.min())
    halves = _sampled(found.value, _points(vectors[None] / 2, 1)[0].round().long())
    if regularity < least or regularity - float(halves.max()) < BETWEEN:
        return None
    # Fisher's transformation and its deviation: few samples say little unless they agree fully
    spreads = 1 / (1 / spreads.clamp(min=1e-6).square() - 3).clamp(min=0.1).sqrt()
    return Lattice(vectors, regularity) if bool((means.atanh() > CHANCE * spreads).all()) else None


def reduced(vectors: Tensor) -> Tensor:
    """The two shortest vectors (..., 2, 2) of lattices that two vectors each span (Lagrange and Gauss)."""
    first, second = vectors.unbind(-2)
    swapped = _squared(second) < _squared(first)
    short, long = torch.where(swapped, second, first), torch.where(swapped, first, second)
    done = torch.zeros_like(swapped)
    while True:
        times = ((long * short).sum(-1, keepdim=True) / _squared(short)).round()
        longer = torch.where(done, long, long - times * short)
        done = _squared(longer) >= _squared(short) - 1e-9
        if bool(done.all()):
            return torch.stack([_upper(short), _upper(longer)], -2)
        short, long = torch.where(done, short, longer), torch.where(done, longer, short)


def _squared(vectors: Tensor) -> Tensor:
    return vectors.square().sum(-1, keepdim=True)


def _upper(vectors: Tensor) -> Tensor:
    """Vectors (..., 2) or their opposites, whichever point down, or right."""
    down, right = vectors.split(1, -1)
    return torch.where((down < 0) | ((down == 0) & (right < 0)), -vectors, vectors)


def _blob(found: Correlation) -> float:
    """Standard deviation of the correlation of unrelated blobs, times the root of how many pixels overlap.

    Its square is the sum of the squared correlation over all lags that are due to no repetition (Bartlett's formula).
    """
    curve = radial(found)
    lags = torch.arange(math.ceil(unlike(curve)) + 1, dtype=torch.float32)[: len(curve)]
    return math.sqrt(1 + float(total(2 * math.pi * lags * curve[: len(lags)].square())))


def _chance(found: Correlation, vectors: Tensor) -> float:
    """The same where a lattice says what is due to repetition: lags nearer to 0 than to other points are not.

    Lines of letters, and courses of bricks, are alike at many of these.
    """
    down, right = (torch.arange(-r, r + 1) for r in found.reach)
    lags = torch.stack(torch.meshgrid(down, right, indexing="ij")).double()
    inside = (Lattice(vectors, 1.0).rest(lags) - lags).abs().amax(0) < 1e-6
    return math.sqrt(float(total(found.value[inside].square())))


def _strongest(found: Correlation, noise: float) -> Tensor:
    """Lags (N, 2) of the strongest peaks on one side of 0; a peak counts less where chance makes larger ones."""
    value = found.value
    around = running(torch.maximum, F.pad(value, (2, 2, 2, 2), value=-1.0), (5, 5))
    inner = running(torch.minimum, F.pad(found.overlap, (1, 1, 1, 1)), (3, 3)) > 0
    peak = (value == around) & inner & (value > 0)
    lags = peak.nonzero() - torch.tensor(found.reach)
    lags = lags[(lags[:, 0] > 0) | ((lags[:, 0] == 0) & (lags[:, 1] > 0))]
    lags = lags[lags.square().sum(1) >= SHORTEST**2]
    sure = _sampled(value, lags) - noise / _sampled(found.overlap, lags).clamp(min=1).sqrt()
    return lags[sure.argsort(descending=True, stable=True)[:STRONGEST]]


def _finest(found: Correlation, lags: Tensor, noise: float) -> Tensor | None:
    """The two lags (2, 2) that span the texture's lattice, None where no two lags span any."""
    if len(lags) < 2:
        return None
    pairs = lags[torch.combinations(torch.arange(len(lags)))].double()
    pairs = reduced(pairs[_area(pairs) > SHORTEST])
    length = pairs.norm(dim=2)
    short, long = length.amin(1), length.amax(1)
    pairs = pairs[(_area(pairs) > 0.5 * short * long) & (short >= SHORTEST) & (long <= LONGEST * short)]
    if not len(pairs):
        return None
    means, spreads = _means(found, pairs, noise)
    score = (means - CHANCE * spreads).amin(1)
    area = torch.where(score >= AS_GOOD * score.max(), _area(pairs), math.inf)
    score = torch.where(area <= 1.1 * area.min(), score, -1.0)
    return pairs[int(score.argmax())]


def _area(vectors: Tensor) -> Tensor:
    return torch.linalg.det(vectors).abs()


def _points(vectors: Tensor, reach: int) -> Tensor:
    """Lattice points (N, K, 2) up to `reach` vectors (N, 2, 2) away along each, one of each two opposite ones."""
    steps = torch.cartesian_prod(*[torch.arange(-reach, reach + 1)] * 2)
    steps = steps[len(steps) // 2 + 1 :].to(vectors)
    return steps @ vectors


def _sampled(image: Tensor, lags: Tensor) -> Tensor:
    """The values of an image of lags, 0 in its middle, at lags (..., 2); 0 beyond its border."""
    (down, right), (height, width) = lags.unbind(-1), image.shape
    inside = (down.abs() <= height // 2) & (right.abs() <= width // 2)
    place = (down + height // 2) * width + right + width // 2
    return torch.where(inside, image.take(torch.where(inside, place, 0)), 0.0)


def _means(found: Correlation, vectors: Tensor, noise: float) -> tuple[Tensor, Tensor]:
    """Mean correlation (N, 3) at near points of lattices (N, 2, 2), and the deviation (N, 3) that chance gives it.

    There are three means: over the points along either vector, and over all others. A texture that repeats in one
    direction alone has no lattice. A point may be missed by a pixel: vectors need not be whole pixels.
    """
    steps = _points(torch.eye(2, dtype=vectors.dtype)[None], NEAR)[0]
    points = (steps @ vectors).round().long()
    value = _sampled(found.highest_near, points)
    overlap = _sampled(found.overlap, points)
    groups = torch.stack([steps[:, 0] == 0, steps[:, 1] == 0, (steps != 0).all(1)], 1).to(overlap)
    count = overlap @ groups
    means = torch.where(count > 0, (value * overlap) @ groups / count.clamp(min=1), 1.0)
    return means, torch.where(count > 0, noise / count.clamp(min=1).sqrt(), 0.0)


def _fitted(found: Correlation, vectors: Tensor) -> Tensor:
    """The vectors (2, 2) fitted to the peaks at their lattice's points, first to the nearest, then farther and farther.

    A peak belongs to a point when it lies within a sixth of the shorter vector; it weighs by what overlaps. Where peaks
    of several points are one, as in pictures of few pixels, vectors that are fitted to them span no lattice: they stay.
    """
    across = math.ceil(math.hypot(*found.reach) / float(vectors.norm(dim=1).min()))
    reach = 1
    while True:
        steps = _points(torch.eye(2, dtype=vectors.dtype)[None], reach)[0]
        near = max(1, min(int(vectors.norm(dim=1).min() / 6), 8))
        place, weight = _peaks_near(found, steps @ vectors, near)
        if int((weight > 0).sum()) >= 2:
            scaled = steps * weight.sqrt()[:, None]
            gram = scaled.T @ scaled
            if float(torch.linalg.det(gram)) > 1e-6:
                fitted = torch.linalg.solve(gram, scaled.T @ (place * weight.sqrt()[:, None]))
                vectors = fitted if bool(_area(fitted) > 0.5 * _area(vectors)) else vectors
        if reach >= across:
            return vectors
        reach *= 2


def _peaks_near(found: Correlation, places: Tensor, near: int) -> tuple[Tensor, Tensor]:
    """The highest peak (K, 2), between samples, up to `near` pixels from places (K, 2); weight (K,), 0 without one."""
    steps = torch.cartesian_prod(*[torch.arange(-near, near + 1)] * 2)
    candidates = places.round().long()[:, None] + steps
    best = _sampled(found.value, candidates).argmax(1)
    peak = candidates[torch.arange(len(places)), best]
    value = _sampled(found.value, peak)
    known = _sampled(found.overlap, candidates).amin(1) > 0
    weight = torch.where(known, value.clamp(min=0) * _sampled(found.overlap, peak), 0.0)
    shift = []
    for axis in torch.eye(2, dtype=torch.long):
        before, after = (_sampled(found.value, peak + sign * axis) for sign in (-1, 1))
        # where all is alike no peak is higher, however its neighbors overlap
        slope = torch.where(value < 1 - 1e-6, before - after, 0.0)
        highest = torch.maximum(before, after) < value - 1e-6
        weight = torch.where(highest, weight, 0.0)
        shift.append(torch.where(highest, 0.5 * slope / (before - 2 * value + after), 0.0))
    return peak + torch.stack(shift, 1).nan_to_num(), weight
