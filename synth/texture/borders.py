"""Where pictures that lie over each other border: along minimum cuts, around elements of both, near where it is wanted.

Each pixel shows one of several pictures. In turn each picture takes what the others show where that lowers

    sum over neighbors p, q of B(p, q, l_p, l_q)  +  WRONG * weight * |pixels that show another than is wanted|

(expansion moves), l the picture that a pixel shows. B is the cost of seams (`kwatra.pieces.seams.cost`) for textures
that are not alike: in units of how unlike they are where they should meet, and hidden only as far as gaps of both
sides hide it, for a border ends elements on either side.
"""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from kwatra.pieces import HIDDEN, cheaper

WRONG = 0.02
"""What a pixel costs that shows another picture than is wanted; one of a border that is not hidden costs about 1.

Two of stones, mosaics, coins, tiles and letters of 32 to 48 pixels in blobs of about 100 (four pairs, two seeds) have
.12 of their elements cut with .005, .15 with .01, .17 with .02 and .20 with .04, and show .89, .93, .95 and .97 of the
pixels as they are wanted. Dearer the further off, as much on average, it is the same."""

ROUNDS = 2
"""So often each picture takes what borders cost less with; four times is no better."""

UNIT = 256
"""What costs 1, as whole numbers, of which cuts are."""


def bordered(
    wanted: np.ndarray,
    near: Sequence[np.ndarray],
    pictures: np.ndarray,
    depths: np.ndarray,
    wraps: Sequence[bool],
    weight: float,
) -> np.ndarray:
    """Which of pictures (k, C, H, W) each pixel shows, (H, W), where it is wanted (H, W) or `near` (k of (H, W)).

    Where a picture is wanted the inner half of each place shows it, however cheap it is to do without.
    depths (k, H, W): how deep in its element each pixel of a picture lies, 0 (ground) to 1. wraps: along which axes the
    last pixel lies before the first; which of them is shown in the first line then stays as it is wanted. Memory: a
    few times the pictures.
    """
    pixels, now = np.arange(wanted.size).reshape(wanted.shape), wanted
    borders, inner = _Borders(pictures, depths, wanted), _inner(wanted)
    for number in [*range(len(pictures))] * ROUNDS:
        free = near[number] & (now != number) & ~inner
        before = now * wanted.size + pixels
        after = np.where(free, number * wanted.size + pixels, before)
        more = np.where(free, (wanted != number).astype(np.int64) - (wanted != now), 0)
        taking = np.rint(UNIT * WRONG * weight * more).astype(np.int64)
        now = np.where(cheaper(borders, before, after, wraps, taking), number, now)
    return now


class _Borders:
    """B of pictures; places are whole numbers: picture * pixels + pixel."""

    def __init__(self, pictures: np.ndarray, depths: np.ndarray, wanted: np.ndarray) -> None:
        self.colors = np.ascontiguousarray(pictures.swapaxes(0, 1)).reshape(pictures.shape[1], -1)
        self.depths, self.pixels, self.unit = depths.ravel(), wanted.size, 1.0
        self.unit = self._unlike_where(wanted)

    def between(self, s: np.ndarray, t: np.ndarray, axis: int, axes: int) -> np.ndarray:
        """What borders cost between places of any shape, of pixels one step apart along an axis; 0 within a picture."""
        depth = (self.depths[s] + self.depths[t]) / 2
        cost = (HIDDEN + (1 - HIDDEN) * depth) * self._unlike(s, t) / self.unit
        return np.where(s // self.pixels == t // self.pixels, 0, np.rint(UNIT * cost)).astype(np.int32)

    def _unlike(self, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """How unlike two pictures are at pixels s of the one and t of the other, together."""
        beyond, before = s - s % self.pixels + t % self.pixels, t - t % self.pixels + s % self.pixels
        unlike = np.zeros(s.shape, np.float32)
        for channel in self.colors:
            unlike += np.abs(channel[s] - channel[before]) + np.abs(channel[beyond] - channel[t])
        return unlike

    def _unlike_where(self, wanted: np.ndarray) -> float:
        """How unlike pictures are on average where they are to meet; 1 where none do."""
        places = wanted * self.pixels + np.arange(self.pixels).reshape(wanted.shape)
        found = list[np.ndarray]()
        for one, other in ((places[1:], places[:-1]), (places[:, 1:], places[:, :-1])):
            meet = one // self.pixels != other // self.pixels
            found.append(self._unlike(one[meet], other[meet]))
        unlike = np.concatenate(found)
        return float(unlike.mean()) or 1.0 if unlike.size else 1.0


def _inner(wanted: np.ndarray) -> np.ndarray:
    """The pixels (H, W) that are further inside what hangs together there than half as far as any."""
    inner = np.zeros(wanted.shape, bool)
    for number in np.unique(wanted):
        there = wanted == number
        if not there.all():
            places, count = ndimage.label(there)
            far = ndimage.distance_transform_edt(there)
            furthest = ndimage.maximum(far, places, np.arange(count + 1))
            inner |= there & (far > furthest[places] / 2)
    return inner
