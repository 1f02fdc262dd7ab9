"""What is looked up place by place, against arrays indexed at once."""

import numpy as np
import pytest

from kwatra.pieces.boxes import Box
from kwatra.pieces.loops import quantile
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.seams import SeamCost
from kwatra.pieces.sheet import Sheet
from kwatra.pieces.weighing import charge_shown, pick, take_known


def test_values_are_taken_where_they_are_known():
    rng = np.random.default_rng(0)
    image, places, known = rng.random((3, 50)), rng.integers(0, 50, 40, np.int32), rng.random(40) < 0.6
    ones, against = np.full((4, 40), np.nan), np.full((2, 40), np.nan)
    energy = take_known(image, places, known, ones, against)
    wanted = np.where(known, image[:, places], 0)
    np.testing.assert_array_equal(ones, [*wanted, known])
    np.testing.assert_allclose(against, [(wanted**2).sum(0), known])
    assert energy == pytest.approx((wanted**2).sum())


@pytest.mark.parametrize("shapes", [[(7, 9)], [(4, 5, 6), (3, 6, 4)]])
def test_coordinates_are_those_that_places_are_made_of(shapes):
    rng = np.random.default_rng(0)
    mosaic = Mosaic([rng.random((2, *shape), np.float32) for shape in shapes])
    for number, shape in enumerate(shapes):
        lines = [np.arange(-1, n + 1) for n in shape]
        home, at = mosaic.coordinates(mosaic.places(number, lines))
        assert (home == number).all()
        np.testing.assert_array_equal(at, np.meshgrid(*lines, indexing="ij"))
        assert home.dtype == at.dtype == np.int32


@pytest.mark.parametrize("start", [(1, 2), (0, 0), (3, 2), (-2, 2), (2, 4), (-1, 5)])
def test_a_box_may_pass_the_border_where_the_sheet_wraps(start):
    mosaic = Mosaic([np.zeros((1, 4, 4), np.float32)])
    sheet = Sheet(mosaic, (6, 7), (True, True), SeamCost(mosaic))
    sheet.label = np.arange(42).reshape(6, 7)
    rows, columns = (np.arange(s, s + e) % n for s, e, n in zip(start, (3, 4), (6, 7), strict=True))
    np.testing.assert_array_equal(sheet.label[sheet.indices(Box(start, (3, 4)))], sheet.label[np.ix_(rows, columns)])
    sheet.places[:], sheet.label[::2] = np.arange(42).reshape(6, 7), -1
    places, known = sheet.shown(Box(start, (3, 4)))
    np.testing.assert_array_equal(places, sheet.places[np.ix_(rows, columns)])
    np.testing.assert_array_equal(known, np.broadcast_to(rows[:, None] % 2 == 1, (3, 4)))


def test_a_quantile_is_numpys_bit_for_bit():
    values = np.random.default_rng(0).random(301)
    for numbers in (values, values.round(1), np.sort(values)[::-1].copy()):
        for count in (1, 2, 3, 40, 301):
            for share in (0.0, 0.05, 0.25, 0.6, 1.0):
                assert quantile(numbers[:count], share) == np.quantile(numbers[:count], share)


def test_what_was_shown_costs_by_how_often_and_how_near_and_whether_it_is_continued():
    rng = np.random.default_rng(0)
    used, near, same = rng.integers(0, 9, (3, 20)).astype(float)
    pixels, cost = rng.integers(9, 12, 20).astype(float), np.empty(20)
    charge_shown(used, near, same, pixels, 0.4, 0.5, 0.3, 0.2, cost)
    by_hand = 0.5 * (used / pixels - 0.4) + 0.3 * (same > 0) + 0.2 * (near - same) / pixels
    np.testing.assert_allclose(cost, by_hand, atol=1e-12)


@pytest.mark.parametrize("most", [1, 4, 30])
def test_blocks_are_picked_by_their_cost_and_of_equals_the_first(most):
    costs = np.random.default_rng(most).integers(0, 9, 25) / 8
    costs[::4] = np.inf
    near = [i for i in np.argsort(costs, kind="stable") if costs[i] <= costs.min() + 0.5]
    np.testing.assert_array_equal(pick(costs, most, 0.5), near[:most])
