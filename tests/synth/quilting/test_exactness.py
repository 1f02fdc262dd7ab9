"""Laying patches against brute force: no labeling of a small canvas may be cheaper than the one that is chosen."""

import itertools

import numpy as np
import pytest

from synth.quilting.boxes import Box
from synth.quilting.canvas import Canvas, Patch
from synth.quilting.costs import SeamCost
from synth.quilting.sources import Sources


def labeling_cost(canvas, patch, take):
    """Seam cost of the whole canvas once the pixels in `take` come from `patch`, from colours alone."""
    label = np.where(take, -2, canvas.label)
    patches = {**dict(enumerate(canvas.patches)), -2: patch}
    image = canvas.sources.planes.reshape(len(canvas.sources.planes), -1, *canvas.sources.cell).astype(int)

    def color(number, at):
        home = patches[number]
        n = canvas.sources.shapes[home.number]
        period = [s if w else 10**6 for s, w in zip(canvas.shape, canvas.periodic, strict=True)]
        u = [(a - (b - 1)) % m + (b - 1) for a, b, m in zip(at, home.box.start, period, strict=True)]
        x = [min(max(c - s, -1), m) + 1 for c, s, m in zip(u, home.shift, n, strict=True)]
        return image[(slice(None), home.number, *x)]

    total = 0
    for at in np.ndindex(*canvas.shape):
        for axis in range(len(at)):
            to = tuple(a + (d == axis) for d, a in enumerate(at))
            if to[axis] == canvas.shape[axis]:
                if not canvas.periodic[axis]:
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
    sources = Sources([rng.random((2, *source), np.float32)])
    canvas = Canvas(sources, shape, periodic, SeamCost(sources))
    for _ in range(6):
        extent = tuple(min(n, canvas.longest(d)) for d, n in enumerate(source))
        start = tuple(
            int(rng.integers(0, s if w else s - e + 1)) for s, e, w in zip(shape, extent, periodic, strict=True)
        )
        patch = Patch(0, start, Box(start, extent))
        at = canvas.indices(patch.box)
        must = rng.random(extent) < 0.1
        must_not = (rng.random(extent) < 0.1) & ~must & canvas.filled[at]
        free = canvas.filled[at] & ~must & ~must_not
        free.ravel()[np.flatnonzero(free.ravel())[6:]] = False
        held = canvas.filled[at] & ~must & ~free
        best = min(_all_labelings(canvas, patch, at, free, ~free & ~held))
        canvas.lay(patch, must=must, must_not=held)
        assert canvas.total == best
        assert canvas.total == int(canvas.seams.sum())
        np.testing.assert_array_equal(canvas.recomputed_seams(), canvas.seams)


def _all_labelings(canvas, patch, at, free, taken):
    spots = np.argwhere(free)
    for choice in itertools.product([False, True], repeat=len(spots)):
        inside = taken.copy()
        inside[tuple(spots.T)] = choice
        take = np.zeros(canvas.shape, bool)
        take[at] = inside
        yield labeling_cost(canvas, patch, take)
