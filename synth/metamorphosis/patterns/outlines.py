"""Outlines: closed contours sampled to landmarks, and the order of one that fits another best."""

import numpy as np
from numpy.typing import NDArray
from skimage import filters, measure

Array = NDArray[np.float64]

_SPIN = 0.25
"""What a turn by 90 degrees costs, beside the share of the shape that the best similarity transform leaves unmet."""


def outline(mask: NDArray[np.bool_], count: int) -> Array:
    """The outer contour of a mask (H, W) as `count` landmarks (count, 2), evenly along it, clockwise on the screen.

    The first lies to the right of the centroid. The contour is smoothed by less than a pixel.
    """
    padded = np.pad(mask.astype(float), 1)
    contours = measure.find_contours(filters.gaussian(padded, 0.6), 0.5)
    contour = max(contours, key=len)[:-1, ::-1] - 1
    contour = contour if _area(contour) > 0 else contour[::-1]
    inside = np.clip(contour, 0, [mask.shape[1] - 1, mask.shape[0] - 1])
    offsets = inside - inside.mean(0)
    return resampled(np.roll(inside, -int(np.abs(np.arctan2(*offsets.T[::-1])).argmin()), 0), count)


def resampled(contour: Array, count: int) -> Array:
    """`count` points (count, 2) evenly along a closed contour (n, 2), from its first point on."""
    closed = np.concatenate([contour, contour[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    places = np.arange(count) / count * along[-1]
    return np.stack([np.interp(places, along, closed[:, axis]) for axis in range(2)], 1)


def alike(a: Array, b: Array, closed_a: bool, closed_b: bool) -> tuple[Array, Array]:
    """Patterns a (n, m, 2) and b (n', m', 2) with equally many landmarks: those that are outlines are sampled anew."""
    count = b.shape[1] if closed_a and not closed_b else a.shape[1]
    sampled = [
        np.stack([resampled(each, count) for each in patterns]) if closed and patterns.shape[1] != count else patterns
        for patterns, closed in ((a, closed_a), (b, closed_b))
    ]
    return sampled[0], sampled[1]


def best_order(outlines: Array, others: Array) -> NDArray[np.int64]:
    """For each outline (n, m, 2) the order (n, m) of the other one's landmarks (n, m, 2) that fits it best.

    Orders are rotations of the indices. The best one is that under whose similarity transform the least part of the
    shape is left, where a turn costs too: discs do not spin.
    """
    shape, other = _centered(outlines), _centered(others)
    count = shape.shape[1]
    orders = (np.arange(count)[:, None] + np.arange(count)) % count
    fits = np.einsum("nm,nsm->ns", shape.conj(), other[:, orders])
    cost = 1 - np.abs(fits) ** 2 + _SPIN * (1 - np.cos(np.angle(fits)))
    return orders[cost.argmin(1)]


def clockwise(outlines: Array) -> NDArray[np.bool_]:
    """Which outlines (n, m, 2) run clockwise on the screen, where y points down."""
    return np.array([_area(each) > 0 for each in outlines], bool)


def _centered(outlines: Array) -> NDArray[np.complex128]:
    """Outlines (n, m, 2) as complex numbers about their centroids, of length 1."""
    points = outlines[..., 0] + 1j * outlines[..., 1]
    points = points - points.mean(1, keepdims=True)
    return points / np.maximum(np.linalg.norm(points, axis=1, keepdims=True), 1e-12)


def _area(contour: Array) -> float:
    """Signed area; above 0 where the contour runs clockwise on the screen."""
    x, y = contour.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
