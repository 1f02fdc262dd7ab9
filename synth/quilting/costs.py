"""The matching cost of a seam between two neighboring pixels s and t that come from patches A and B.

    M(s, t, A, B)  = |A(s) - B(s)| + |A(t) - B(t)|                                        (thesis equation 1)
    M'(s, t, A, B) = M / (|G_A(s)| + |G_A(t)| + |G_B(s)| + |G_B(t)|),  G along s -> t      (thesis equation 5)
                     times ACROSS_TIME where s -> t is a step in time

|.| is the sum over channels of absolute differences of quantized colours: whole numbers, so M is a metric without any
rounding and sums of it are exact. M' prefers seams through busy regions, where they show less; it is no metric, and the
cut then treats an old seam as costing at most what replacing it on both sides would (kwatra.cut). Use M where
the cut must be the best possible, M' where flat and busy regions mix.
"""

from __future__ import annotations

import numpy as np

from synth.quilting.sources import LEVELS, Sources

NORMALIZED_SCALE = 4096
ACROSS_TIME = 2
"""What a seam between frames costs more in M'. Each pixel passes from patch to patch in some frame; where it were as
cheap as a seam within a frame, all would pass in one, which is the smallest surface, and is seen as a flash."""
FLAT = 0.02
"""Gradient, per channel and as a fraction of the colour range, that a perfectly flat region is taken to have in M'."""


class SeamCost:
    """M, or M' if `normalized`, for pixels given by their places in the mosaic of `sources`."""

    def __init__(self, sources: Sources, normalized: bool = False):
        self.planes = sources.planes
        self.strides = sources.strides
        self.gradients = _gradients(sources) if normalized else None
        self.flat = int(4 * FLAT * LEVELS * len(self.planes))
        self.unit = 1.0 / NORMALIZED_SCALE if normalized else 1.0 / LEVELS

    def difference(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """|A - B| at one pixel, from the places of its two colours; int32."""
        total = np.zeros(np.broadcast_shapes(a.shape, b.shape), np.int32)
        for plane in self.planes:
            total += np.abs(plane[a] - plane[b])
        return total

    def pair(self, axis: int, s: tuple[np.ndarray, np.ndarray], t: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Cost of the pairs (s, t), t one step along `axis`; each of `s` and `t` is (place under A, place under B)."""
        return self.from_differences(axis, self.difference(*s) + self.difference(*t), s, t)

    def from_differences(
        self, axis: int, match: np.ndarray, s: tuple[np.ndarray, np.ndarray], t: tuple[np.ndarray, np.ndarray]
    ) -> np.ndarray:
        """As `pair`, where M itself is known already."""
        if self.gradients is None:
            return match
        slope = self.gradients[axis]
        busy = slope[s[0]] + slope[t[0]] + slope[s[1]] + slope[t[1]] + self.flat
        scale = NORMALIZED_SCALE * (ACROSS_TIME if axis < len(self.strides) - 2 else 1)
        return (match.astype(np.int64) * scale // busy).astype(np.int32)


def _gradients(sources: Sources) -> list[np.ndarray]:
    """Per axis the summed absolute central difference at each place of the mosaic (rim included); int32."""
    cells = [np.zeros((len(sources.shapes), *sources.cell), np.int32) for _ in range(sources.dims)]
    planes = sources.planes.reshape(len(sources.planes), len(sources.shapes), *sources.cell)
    for number, shape in enumerate(sources.shapes):
        inner = tuple(slice(0, n + 2) for n in shape)
        for axis, cell in enumerate(cells):
            for plane in planes:
                cell[number][inner] += _slope(plane[number][inner].astype(np.int32), axis)
    return [cell.reshape(-1) for cell in cells]


def _slope(values: np.ndarray, axis: int) -> np.ndarray:
    padded = np.pad(values, [(1, 1) if d == axis else (0, 0) for d in range(values.ndim)], mode="edge")
    count = values.shape[axis]
    return np.abs(np.take(padded, range(2, count + 2), axis) - np.take(padded, range(count), axis)) // 2
