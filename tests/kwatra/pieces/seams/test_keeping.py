from itertools import product

import numpy as np
import pytest
from scipy import ndimage

from kwatra.pieces import Mosaic, SeamCost, cheaper


def price(cost, places):
    return sum(int(part.sum(dtype=np.int64)) for part in cost.within(places))


def stock(seed, side=8):
    mosaic = Mosaic([np.random.default_rng(seed).random((2, side, side), dtype=np.float32)])
    return mosaic, SeamCost(mosaic)


def patch(mosaic, shape, down, right):
    row, column = np.indices(shape)
    return mosaic.places_of([row + down, column + right])


def test_seams_between_some_places_cost_what_they_do_within_all():
    mosaic, cost = stock(5)
    places = np.where(np.arange(6) < 3, patch(mosaic, (5, 6), 1, 0), patch(mosaic, (5, 6), 3, 2))
    for axis, whole in enumerate(cost.within(places)):
        s, t = (np.delete(places, end, axis) for end in (-1, 0))
        some = np.random.default_rng(0).random(s.shape) < 0.5
        np.testing.assert_array_equal(cost.between(s[some], t[some], axis, 2), whole[some])
        assert (whole > 0).sum() == (5 if axis == 1 else 0)  # one seam down, none across


@pytest.mark.parametrize("seed", range(6))
def test_one_later_patch_is_taken_where_seams_cost_least(seed):
    mosaic, cost = stock(seed)
    left, right = patch(mosaic, (3, 4), 0, 0), patch(mosaic, (3, 4), 4, 3)
    before = np.where(np.arange(4) < 2, left, right)
    after = patch(mosaic, (3, 4), 2, 1)
    ways = (np.array(way).reshape(3, 4) for way in product([False, True], repeat=12))
    least = min(price(cost, np.where(way, after, before)) for way in ways)
    assert price(cost, np.where(cheaper(cost, before, after), after, before)) == least


@pytest.mark.parametrize("wraps", [(True, False), (False, True), (True, True)])
@pytest.mark.parametrize("seed", range(4))
def test_what_wraps_is_cut_all_around(seed, wraps):
    mosaic, cost = stock(seed)
    before = np.where(np.arange(5) < 3, patch(mosaic, (3, 5), 0, 0), patch(mosaic, (3, 5), 4, 3))
    after = patch(mosaic, (3, 5), 2, 1)

    def around(way):
        return price(cost, np.pad(np.where(way, after, before), [(0, int(wrap)) for wrap in wraps], "wrap"))

    def ways():
        free = np.ones((3, 5), bool)
        free[0] &= not wraps[0]
        free[:, 0] &= not wraps[1]
        for chosen in product([False, True], repeat=int(free.sum())):
            way = np.zeros((3, 5), bool)
            way[free] = chosen
            yield way

    take = cheaper(cost, before, after, wraps)
    assert take.shape == (3, 5)
    assert around(take) == min(map(around, ways()))


@pytest.mark.parametrize("seed", [0, 8, 14, 26, 30, 35])
def test_what_later_seams_cost_counts_where_they_are_taken(seed):
    rng = np.random.default_rng(seed)
    mosaic = Mosaic([ndimage.gaussian_filter(rng.random((2, 12, 12)).astype(np.float32), (0, 1, 1))])
    cost, (rows, columns) = SeamCost(mosaic), np.indices((3, 4))
    one, other, later, last = (patch(mosaic, (3, 4), *rng.integers(0, 8, 2)) for _ in range(4))
    before, after = np.where(columns < 1 + seed % 3, one, other), np.where(rows < 1 + seed % 2, later, last)
    ways = (np.array(way).reshape(3, 4) for way in product([False, True], repeat=12))
    least = min(price(cost, np.where(way, after, before)) for way in ways)
    assert price(cost, np.where(cheaper(cost, before, after), after, before)) == least


@pytest.mark.parametrize("seed", range(6))
def test_what_pixels_cost_that_go_over_counts_beside_seams(seed):
    mosaic, cost = stock(seed)
    before = np.where(np.arange(4) < 2, patch(mosaic, (3, 4), 0, 0), patch(mosaic, (3, 4), 4, 3))
    after = patch(mosaic, (3, 4), 2, 1)
    more = np.random.default_rng(seed).integers(-4000, 4000, (3, 4))
    ways = [np.array(way).reshape(3, 4) for way in product([False, True], repeat=12)]
    prices = [price(cost, np.where(way, after, before)) + int(more[way].sum()) for way in ways]
    take = cheaper(cost, before, after, taking=more)
    assert price(cost, np.where(take, after, before)) + int(more[take].sum()) == min(prices)
    assert not cheaper(cost, before, after, taking=np.full((3, 4), 10**6)).any()


@pytest.mark.parametrize("seed", range(60))
def test_seams_never_cost_more_than_before(seed):
    mosaic, cost = stock(seed)
    rng = np.random.default_rng(seed)
    before, after = (mosaic.places_of(list(rng.integers(0, 8, (2, 6, 7)))) for _ in range(2))
    assert price(cost, np.where(cheaper(cost, before, after), after, before)) <= price(cost, before)


def test_only_the_part_that_mends_a_seam_is_taken():
    mosaic, cost = stock(0, 32)
    whole, other = patch(mosaic, (8, 24), 0, 0), patch(mosaic, (8, 24), 20, 7)
    columns = np.broadcast_to(np.arange(24), (8, 24))
    before = np.where((columns > 2) & (columns < 6), other, whole)
    after = np.where((columns > 16) & (columns < 20), other, whole)
    take = cheaper(cost, before, after)
    assert (np.where(take, after, before) == whole).all()
    assert not cheaper(cost, whole, after).any()
