"""Laying patches against brute force: no labeling of a small sheet may be cheaper than the one that is chosen."""

import itertools

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.seams import SeamCost
from kwatra.pieces.sheet import Patch, Sheet


def labeling_cost(sheet, patch, take):
    """Seam cost of the whole sheet once the pixels in `take` come from `patch`, from colours alone."""
    label = np.where(take, -2, sheet.label)
    patches = {**dict(enumerate(sheet.patches)), -2: patch}
    image = sheet.sources.planes.reshape(len(sheet.sources.planes), -1, *sheet.sources.cell).astype(int)

    def color(number, at):
        home = patches[number]
        n = sheet.sources.shapes[home.number]
        period = [s if w else 10**6 for s, w in zip(sheet.shape, sheet.periodic, strict=True)]
        u = [(a - (b - 1)) % m + (b - 1) for a, b, m in zip(at, home.box.start, period, strict=True)]
        x = [min(max(c - s, -1), m) + 1 for c, s, m in zip(u, home.shift, n, strict=True)]
        return image[(slice(None), home.number, *x)]

    total = 0
    for at in np.ndindex(*sheet.shape):
        for axis in range(len(at)):
            to = tuple(a + (d == axis) for d, a in enumerate(at))
            if to[axis] == sheet.shape[axis]:
                if not sheet.periodic[axis]:
                    continue
                to = tuple(0 if d == axis else a for d, a in enumerate(at))
            if label[at] != label[to] and label[at] != -1 and label[to] != -1:
                total += np.abs(color(label[at], at) - color(label[to], at)).sum()
                total += np.abs(color(label[at], to) - color(label[to], to)).sum()
    return int(total)


@pytest.mark.parametrize(
    ("shape", "source", "periodic"),
    [
        ((5, 6), (4, 4), (False, False)),
        ((6, 6), (4, 4), (True, True)),
        ((3, 4, 4), (3, 3, 3), (False, False, False)),
        ((5, 3, 3), (3, 3, 3), (True, False, False)),
    ],
)
@pytest.mark.parametrize("seed", range(4))
def test_laying_a_patch_over_old_seams_is_optimal(shape, source, periodic, seed):
    rng = np.random.default_rng(seed)
    sources = Mosaic([rng.random((2, *source), np.float32)])
    sheet = Sheet(sources, shape, periodic, SeamCost(sources))
    for _ in range(6):
        extent = tuple(min(n, sheet.longest(d)) for d, n in enumerate(source))
        start = tuple(
            int(rng.integers(0, s if w else s - e + 1)) for s, e, w in zip(shape, extent, periodic, strict=True)
        )
        patch = Patch(0, start, Box(start, extent))
        at = sheet.indices(patch.box)
        must = rng.random(extent) < 0.1
        must_not = (rng.random(extent) < 0.1) & ~must & sheet.filled[at]
        free = sheet.filled[at] & ~must & ~must_not
        free.ravel()[np.flatnonzero(free.ravel())[6:]] = False
        held = sheet.filled[at] & ~must & ~free
        best = min(_all_labelings(sheet, patch, at, free, ~free & ~held))
        sheet.lay(patch, must=must, must_not=held)
        assert sheet.total == best
        assert sheet.total == int(sheet.seams.sum())
        np.testing.assert_array_equal(sheet.recomputed_seams(), sheet.seams)


def _all_labelings(sheet, patch, at, free, taken):
    spots = np.argwhere(free)
    for choice in itertools.product([False, True], repeat=len(spots)):
        inside = taken.copy()
        inside[tuple(spots.T)] = choice
        take = np.zeros(sheet.shape, bool)
        take[at] = inside
        yield labeling_cost(sheet, patch, take)
