"""Cuts solved coarse to fine: as good as exact ones where a seam is wide enough to be seen coarsely."""

import numpy as np
import pytest
from scipy import ndimage

from kwatra.cut import FREE, KEEP, TAKE, best_cut, seams_after
from kwatra.cut import minimum as cut
from kwatra.cut.bands import _held


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


@pytest.mark.parametrize("seed", range(4))
def test_what_taking_costs_counts_where_pixels_are_free_alone(seed, monkeypatch) -> None:
    choice, pairs = problem((33, 40), seed)
    choice[5:30:4, 5:38:4] = KEEP
    rng = np.random.default_rng(seed)
    taking = (ndimage.gaussian_filter(rng.standard_normal(choice.shape), 5) * 20000).astype(np.int64)

    def price(take) -> int:
        return cost(choice, take, pairs) + int(taking[take & (choice == FREE)].sum())

    exact, unasked = (price(best_cut(choice, pairs, asked)) for asked in (taking, None))
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 200)
    take = best_cut(choice, pairs, taking)
    spread = unasked - exact
    assert spread > 0
    assert price(take) - exact < 0.2 * spread
    elsewhere = np.where(choice == FREE, taking, -(10**6))
    np.testing.assert_array_equal(best_cut(choice, pairs, elsewhere), take)


def test_all_is_taken_that_costs_less_when_taken(monkeypatch) -> None:
    choice, pairs = problem((33, 40), 0)
    choice[:] = FREE
    monkeypatch.setattr(cut, "MOST_AT_ONCE", 200)
    assert best_cut(choice, pairs, np.full(choice.shape, -10)).all()
    assert not best_cut(choice, pairs, np.full(choice.shape, 10)).any()


@pytest.mark.parametrize("shape", [(7, 9), (4, 5, 3)])
def test_what_is_held_costs_a_band_what_it_does(shape) -> None:
    rng = np.random.default_rng(1)
    unary, free = rng.integers(-50, 50, shape), rng.random(shape) < 0.8
    band, guess = free & (rng.random(shape) < 0.5), free & (rng.random(shape) < 0.5)
    pairs = [np.diff(np.arange(np.prod(shape)).reshape(shape), axis=axis).shape for axis in range(len(shape))]
    arcs = [(rng.integers(0, 50, pair), rng.integers(0, 50, pair)) for pair in pairs]
    for axis, arc in enumerate(arcs):  # as `energy` has it, of free pixels alone
        both = np.take(free, range(shape[axis] - 1), axis) & np.take(free, range(1, shape[axis]), axis)
        for way in arc:
            way *= both

    def price(take, unary, arcs) -> int:
        total = int(unary[take].sum())
        for axis, (ahead, back) in enumerate(arcs):
            p, q = np.take(take, range(shape[axis] - 1), axis), np.take(take, range(1, shape[axis]), axis)
            total += int(ahead[~p & q].sum() + back[p & ~q].sum())
        return total

    inner = _held(unary, arcs, free, guess, band)
    apart = set()
    for _ in range(20):
        within = band & (rng.random(shape) < 0.5)
        apart.add(price(np.where(band, within, guess), unary, arcs) - price(within, *inner))
    assert len(apart) == 1
