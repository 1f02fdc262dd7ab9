"""Cuts solved coarse to fine: as good as exact ones where a seam is wide enough to be seen coarsely."""

import numpy as np
import pytest
from scipy import ndimage

from kwatra.cut import FREE, KEEP, TAKE, best_cut, seams_after
from kwatra.cut import minimum as cut


def problem(shape: tuple[int, ...], seed: int):
    """Two patches that differ by smooth noise, the first kept at one end, the second wanted at the other."""
    rng = np.random.default_rng(seed)
    difference = 1 + np.abs(ndimage.gaussian_filter(rng.standard_normal(shape), 3) * 2000).astype(np.int32)
    choice = np.full(shape, FREE)
    choice[0], choice[-1] = KEEP, TAKE
    pairs = []
    for axis in range(len(shape)):
        p = np.take(difference, range(shape[axis] - 1), axis)
        q = np.take(difference, range(1, shape[axis]), axis)
        pairs.append((np.zeros_like(p), p + q, p + q))
    return choice, pairs


def cost(choice, take, pairs) -> int:
    return sum(int(s.sum()) for s in seams_after(choice, take, pairs))


@pytest.mark.parametrize(("shape", "most"), [((33, 40), 1.25), ((17, 16, 21), 1.01)])
@pytest.mark.parametrize("seed", range(4))
def test_a_banded_cut_is_nearly_as_cheap_as_the_exact_one(shape, most, seed, monkeypatch) -> None:
    choice, pairs = problem(shape, seed)
    exact = cost(choice, best_cut(choice, pairs), pairs)
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 200)
    take = best_cut(choice, pairs)
    assert take[-1].all()
    assert not take[0].any()
    assert exact <= cost(choice, take, pairs) <= most * exact


def test_a_free_way_of_some_width_is_found(monkeypatch) -> None:
    choice, pairs = problem((48, 40), 0)
    for _, b, c in pairs:
        b[20:30], c[20:30] = 0, 0
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 400)
    assert cost(choice, best_cut(choice, pairs), pairs) == 0


@pytest.mark.parametrize(("shape", "calls"), [((40, 40), 0), ((10, 16, 10), 2)])
def test_in_three_dimensions_cuts_are_banded_sooner(shape, calls, monkeypatch) -> None:
    choice, pairs = problem(shape, 0)
    sizes = []
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 3000)
    solve = cut._solve
    monkeypatch.setattr(cut, "_solve", lambda *problem: (sizes.append(problem[2].sum()), solve(*problem))[1])
    best_cut(choice, pairs)
    assert len(sizes) == calls


def test_parts_that_do_not_touch_are_cut_exactly_however_many_they_are(monkeypatch) -> None:
    choice, pairs = problem((40, 40), 1)
    choice[:, 7::8], choice[9::10, 3] = KEEP, TAKE
    taking = np.random.default_rng(0).integers(-900, 900, choice.shape)
    exact = best_cut(choice, pairs, taking)
    largest = 8 * 40
    monkeypatch.setattr(cut, "MOST_AT_ONCE", largest)
    np.testing.assert_array_equal(best_cut(choice, pairs, taking), exact)
    monkeypatch.setattr(cut, "MOST_AT_ONCE", largest // 3)
    assert (best_cut(choice, pairs, taking) != exact).any()
