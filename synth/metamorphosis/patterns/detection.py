"""Where the pattern is: votes for its centroid, and the shape of each find (Liu et al. 2002, 4.2.2 and 4.2.3).

Every pixel that looks like a landmark votes for where the centroid would be, with a weight that falls off as a
Gaussian; maxima of the votes are candidates (generalized Hough transform). Each candidate is then aligned as an active
shape is: landmarks move to where they look best nearby, and toward the shape that the pattern has under the
similarity transform that fits them. The distance that is left weighs shape and look.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage.feature import peak_local_max

from synth.metamorphosis.patterns.features import distances, features, radius

Array = NDArray[np.float64]

_ALIKE = 0.55
"""Distance of a look that counts half as much as the same look. Of 62 discs and crosses in noise (`bench_patterns.py`)
61 are found with it, 32 with .4 and none with .7; others of those below (by a third to a half) find as many."""

_CONFIDENCE = 0.3
"""Looks less alike than this have no vote."""

_BLUR = 0.2
"""How far a landmark may lie from its place in the pattern, as a share of the pattern's size."""

_LEAST_VOTE = 0.25
"""A candidate has at least this share of the largest vote."""

_LOOKS = 3
"""So often the look of landmarks is learned anew from what was found."""

_REACH = 0.35
"""How far landmarks are drawn to places that look right, as a share of the pattern's size ..."""

_ROUNDS = 8
"""... less and less far in so many rounds."""
_APART = 1.2
"""Another pattern's center is so far away, in radii of a pattern to that side."""
_THIN = 0.35
"""A pattern is at least so wide as a part of its length: landmarks may lie on a line."""
_SHAPE = 2.0
"""What the shape's distance, a share of the radius, counts beside that of the look."""

_CHANCE = 0.05
"""Share of the shapes aligned by chance that may come down to the threshold: of .05 and less on crosses in noise."""


@dataclass(frozen=True)
class Detection:
    """What was found: landmarks (n, m, 2), distances (n,), the votes (H, W), the candidates' centers (k, 2)."""

    landmarks: Array
    distances: Array
    votes: Array
    candidates: Array
    threshold: float


def detect(image: Array, landmarks: Array, threshold: float | None = None) -> Detection:
    """The patterns in an image (H, W, C) that are like the one with landmarks (m, 2), nearest first.

    threshold: the largest distance that is still the pattern; by default what shapes that are aligned where votes are
    fewest do not come down to.
    """
    size, offsets = radius(landmarks), landmarks - landmarks.mean(0)
    maps = features(image, size)
    shapes = landmarks[None]
    for _ in range(_LOOKS):
        looks = distances(maps, shapes)
        votes = _votes(looks, offsets, size)
        candidates = _peaks(votes, size, _LEAST_VOTE)
        found, far = _found(looks, offsets, candidates, size)
        _, chance = _found(looks, offsets, _peaks(votes.max() - votes, size, 0.5), size)
        limit = _unlikely(chance) if threshold is None else threshold
        shapes = found[far <= limit] if (far <= limit).any() else shapes
    return Detection(found[far <= limit], far[far <= limit], votes, candidates, limit)


def _peaks(votes: Array, size: float, least: float) -> Array:
    """The places (k, 2), x first, of maxima of at least a share of the largest, half a radius or more apart."""
    peaks = peak_local_max(votes, min_distance=max(1, round(size / 2)), threshold_rel=least, exclude_border=1)
    return peaks[:, ::-1].astype(float)


def _found(looks: Array, offsets: Array, centers: Array, size: float) -> tuple[Array, Array]:
    """The aligned shapes (n, m, 2) that lie in the image, one at a place, and their distances (n,), least first."""
    shapes = _aligned(looks, offsets, centers, size)
    shapes = shapes[_inside(shapes, looks.shape[1:])]
    return _single(shapes, _distance(looks, offsets, shapes, size))


def _votes(looks: Array, offsets: Array, size: float) -> Array:
    """The votes (H, W) for centroids: 1 where all landmarks look exactly so where they should be."""
    alike = 0.5 ** ((looks / _ALIKE) ** 2)
    alike[alike < _CONFIDENCE] = 0
    votes = np.zeros(looks.shape[1:])
    for look, offset in zip(alike, offsets, strict=True):
        near = ndimage.maximum_filter(look, size=2 * round(_BLUR * size) + 1)
        votes += ndimage.shift(near, -offset[::-1], order=1)
    return ndimage.gaussian_filter(votes / len(offsets), _BLUR * size)


def _aligned(looks: Array, offsets: Array, centers: Array, size: float) -> Array:
    """The shapes (k, m, 2) of candidates at centers (k, 2): first anywhere near, then nearer and nearer."""
    shapes = centers[:, None] + offsets[None]
    for part in np.linspace(1, 0, _ROUNDS):
        reach = max(1, round(_REACH * size * part))
        moved = _moved(looks, shapes, reach)
        shapes = part * _fitted(offsets, moved) + (1 - part) * (_fitted(offsets, moved) + moved) / 2
    return shapes


def _moved(looks: Array, shapes: Array, reach: int) -> Array:
    """Each landmark where it looks best within `reach` px, between pixels where parabolas through them are least."""
    steps = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * 2), -1).reshape(-1, 2)
    steps = steps[(steps**2).sum(1) <= reach**2]
    places = np.rint(shapes)[:, :, None] + steps
    x, y = _pixels(places, looks)
    best = looks[np.arange(looks.shape[0])[:, None], y, x].argmin(2)
    whole = np.take_along_axis(places, best[..., None, None], 2)[:, :, 0]
    return whole + np.stack([_least(looks, whole, step) for step in np.eye(2)], -1)


def _least(looks: Array, places: Array, step: Array) -> Array:
    """How far (k, m) from places (k, m, 2), in [-.5, .5] steps, the parabola through three looks is least."""
    number = np.arange(len(looks))
    before, here, after = (looks[number, y, x] for x, y in (_pixels(places + k * step, looks) for k in (-1, 0, 1)))
    bend = before - 2 * here + after
    return np.asarray(((before - after) / (2 * np.maximum(bend, 1e-9))).clip(-0.5, 0.5) * (bend > 0))


def _fitted(offsets: Array, shapes: Array) -> Array:
    """The pattern, offsets (m, 2), under the similarity transforms that fit shapes (k, m, 2) best."""
    pattern = offsets[:, 0] + 1j * offsets[:, 1]
    points = shapes[..., 0] + 1j * shapes[..., 1]
    middle = points.mean(1, keepdims=True)
    turn = ((points - middle) @ pattern.conj())[:, None] / max(float((abs(pattern) ** 2).sum()), 1e-12)
    fitted = middle + turn * pattern
    return np.stack([fitted.real, fitted.imag], -1)


def _distance(looks: Array, offsets: Array, shapes: Array, size: float) -> Array:
    """The distance (k,) of shapes from the pattern: of the shape, scaled to its size, and of the look."""
    own = shapes - shapes.mean(1, keepdims=True)
    scale = np.sqrt((own**2).sum(2).mean(1)) / size
    unlike = np.linalg.norm(own / np.maximum(scale, 1e-6)[:, None, None] - offsets, axis=2).mean(1) / size
    x, y = _pixels(shapes, looks)
    return _SHAPE * unlike + looks[np.arange(len(offsets)), y, x].mean(1)


def _pixels(places: Array, looks: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The x and y of the pixels of maps (m, H, W) nearest to places (..., 2)."""
    height, width = looks.shape[1:]
    nearest = np.rint(places).astype(int)
    return nearest[..., 0].clip(0, width - 1), nearest[..., 1].clip(0, height - 1)


def _inside(shapes: Array, image: tuple[int, ...]) -> NDArray[np.bool_]:
    edge = np.array([image[1] - 1, image[0] - 1])
    return np.asarray(((shapes >= 0) & (shapes <= edge)).all((1, 2)))


def _single(shapes: Array, far: Array) -> tuple[Array, Array]:
    """Of shapes (n, m, 2) of which one's center lies within the other, that with the least distance."""
    kept: list[int] = []
    centers, whitened = shapes.mean(1), [_whitened(shape) for shape in shapes]
    for number in np.argsort(far, kind="stable"):
        away = ((centers[number] - centers[other]) @ whitened[other] for other in kept)
        if all(np.linalg.norm(there) >= _APART for there in away):
            kept.append(int(number))
    return shapes[kept], far[kept]


def _whitened(shape: Array) -> Array:
    """The matrix (2, 2) in whose units a shape (m, 2) reaches equally far on all sides, its radius being 1."""
    values, axes = np.linalg.eigh(2 * np.cov(shape.T, bias=True))
    spread = np.sqrt(np.maximum(values, _THIN**2 * values.max()))
    return np.asarray(axes / np.maximum(spread, 1e-9) @ axes.T)


def _unlikely(chance: Array) -> float:
    """The distance that shapes aligned by chance, whose distances (n,) these are, do not come down to."""
    if not len(chance):
        return float("inf")
    return float(np.quantile(chance, _CHANCE))
