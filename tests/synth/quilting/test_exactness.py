"""The cut against brute force: no labeling of a small grid may be cheaper than the one it finds."""

import importlib.util
import itertools

import numpy as np
import pytest

from synth.quilting.boxes import Box
from synth.quilting.canvas import Canvas, Patch
from synth.quilting.costs import SeamCost
from synth.quilting.cut import FREE, KEEP, TAKE, VOID, best_cut, seams_after
from synth.quilting.sources import Sources


def random_problem(rng, shape, metric=True):
    """States and pair costs as a canvas would make them: three or more 'patches' as random colours per pixel."""
    dims = len(shape)
    state = rng.choice([KEEP, TAKE, FREE, FREE, FREE, VOID], size=shape)
    pairs = []
    for axis in range(dims):
        less = tuple(n - (d == axis) for d, n in enumerate(shape))
        at, bt, old = rng.integers(0, 50, (3, 2, *less))
        b, c = np.abs(at - bt)
        a = np.abs(at[0] - old[0]) if not metric else np.minimum(np.abs(old[0] - old[1]), b + c)
        pairs.append((a * rng.integers(0, 2, less), b, c))
    return state, pairs


def brute_force(state, pairs, truncated=False):
    free = np.argwhere(state == FREE)
    if truncated:
        pairs = [(np.minimum(a, b + c), b, c) for a, b, c in pairs]
    best = None
    for choice in itertools.product([False, True], repeat=len(free)):
        take = state == TAKE
        take[tuple(free.T)] = choice
        cost = sum(int(s.sum()) for s in seams_after(state, take, pairs))
        best = cost if best is None else min(best, cost)
    return best


@pytest.mark.parametrize("shape", [(3, 4), (1, 9), (2, 2, 3), (3, 2, 2)])
@pytest.mark.parametrize("seed", range(12))
def test_cut_equals_the_best_of_all_labelings(shape, seed):
    rng = np.random.default_rng(seed)
    state, pairs = random_problem(rng, shape)
    take = best_cut(state, pairs)
    assert sum(int(s.sum()) for s in seams_after(state, take, pairs)) == brute_force(state, pairs)
    assert take[state == TAKE].all()
    assert not take[(state == KEEP) | (state == VOID)].any()


@pytest.mark.parametrize("seed", range(12))
def test_without_the_triangle_inequality_the_cut_still_never_costs_more_than_keeping_all(seed):
    rng = np.random.default_rng(seed)
    state, pairs = random_problem(rng, (3, 4), metric=False)
    state[(state == TAKE) | (state == VOID)] = FREE
    take = best_cut(state, pairs)
    after = sum(int(s.sum()) for s in seams_after(state, take, pairs))
    assert after <= sum(int(a.sum()) for a, _, _ in pairs)


@pytest.mark.skipif(importlib.util.find_spec("maxflow") is None, reason="PyMaxflow is an extra")
@pytest.mark.parametrize("seed", range(6))
def test_both_solvers_find_the_same_cost(seed):
    state, pairs = random_problem(np.random.default_rng(seed), (4, 5, 3))
    costs = [sum(int(s.sum()) for s in seams_after(state, best_cut(state, pairs, way), pairs)) for way in (True, False)]
    assert costs[0] == costs[1]


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
