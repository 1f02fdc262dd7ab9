"""What blocks cost and which are picked, against arrays worked on at once."""

import numpy as np
import pytest

from kwatra.pieces.choosing.comparing import sum_near
from kwatra.pieces.choosing.seen import Around, Charges, Compared
from kwatra.pieces.choosing.weighing import attain, charge_shown, draw, keep_in_step, pick, pick_each, weigh


def test_attainable_lies_between_the_least_and_a_good_one_and_never_at_nothing():
    values, every, none = np.linspace(1.0, 3.0, 101), np.ones(101, bool), np.zeros(101)
    valid, same = values > 1.5, (values < 2.0).astype(float)
    assert attain(values, every, none, 0.05, 0.2) == pytest.approx(np.sqrt(1.0 * 1.1))
    assert attain(0 * values, every, none, 0.05, 0.2) == 0.2
    assert attain(values, valid, same, 0.05, 0.2) == pytest.approx(np.sqrt(2.0 * 2.05))  # of those from 2 to 3
    assert attain(values, valid, same + 1, 0.05, 0.2) == pytest.approx(np.sqrt(1.52 * np.quantile(values[valid], 0.05)))


def test_what_was_shown_costs_by_how_often_and_how_near_and_whether_it_is_continued():
    rng = np.random.default_rng(0)
    worn, pixels = rng.random(20), rng.integers(9, 12, 20).astype(float)
    (near, same), cost = rng.integers(0, 9, (2, 20)).astype(float), np.empty(20)
    by_hand = worn + 0.3 * (same > 0)
    charge_shown(worn, near, same, pixels, 0.3, 0.2, cost)
    np.testing.assert_allclose(cost, by_hand + 0.2 * (near - same) / pixels, atol=1e-12)
    charge_shown(worn, np.empty(0), same, pixels, 0.3, 0.0, cost)
    np.testing.assert_allclose(cost, by_hand, atol=1e-12)


def test_what_was_shown_before_is_no_reason_to_leave_the_lattice():
    step = np.array([0.0, 0.01, 0.2, 0.24, 0.0, 0.25])
    shown = np.array([0.5, 0.7, -0.1, 0.0, 0.1, 0.9])
    valid = np.array([True, True, True, True, False, True])
    cost = shown.copy()
    keep_in_step(step, 0.125, False, valid, cost)  # in step are the first two and one that is not valid
    np.testing.assert_allclose(cost, [0, 0.21, 0.2, 0.24, 0, 0.65])
    cost = shown.copy()
    keep_in_step(step + 0.3, 0.125, False, valid, cost)
    np.testing.assert_allclose(cost, shown + step + 0.3)  # none is in step
    for more, least in ((0.0, [0, 0.21]), (0.3, [np.inf, np.inf])):
        cost = shown.copy()
        keep_in_step(step + more, 0.125, True, valid, cost)
        np.testing.assert_allclose(cost[:4], [*least, np.inf, np.inf])


def compared_as(found):
    """What is compared so that `compare` finds (b, k, n) of what is known of one pixel."""
    boxes, images, _ = found.shape
    against = np.zeros((boxes, images + 1, 1, 1, 1))
    against[:, -1] = 1
    return Compared(
        found, against, np.empty((0, 0, 0)), False, ((np.zeros(1, int),) * 3,) * 2, 0.25, np.ones(images), 1e9
    )


def shown_around(boxes, twins):
    """A sheet of 7 x 8 pixels with boxes on it that shows 30 places of a mosaic at random, and their sums."""
    rng, lines = np.random.default_rng(1), (np.zeros(1, int), np.arange(5), np.arange(6))
    places, label = rng.integers(0, 30, (7, 8), np.int32), rng.integers(-1, 3, (7, 8), np.int32)
    spans = lines, tuple(line + 1 for line in lines)
    made = Around(places, label, twins, boxes[:, 0], boxes[:, 1], 3, np.array([5, 6]), spans)
    near = np.empty((len(boxes), 30))
    sum_near(made, near)
    return made, near


def charges(missed, away, used, pixels, around, steps, more, only=False):
    """What 30 blocks of a pixel each are charged that were used so often (5, 6)."""
    lines = np.zeros(1, int), np.arange(5), np.arange(6)
    under = lines, tuple(line + 1 for line in lines)
    return Charges(missed, away, used[None, None], under, pixels, 30, 0.5, around, 0.3, 0.2, steps, 0.25, only, more)


@pytest.mark.parametrize("only", [False, True])
def test_a_block_costs_what_it_disagrees_and_all_that_is_charged(only):
    rng, nothing, twins = np.random.default_rng(0), np.empty((2, 0)), np.empty((0, 0), np.int32)
    found, valid = rng.random((2, 2, 30)).round(6), rng.random((2, 30)) < 0.8
    same, missed = rng.integers(0, 2, (2, 30)).astype(float), rng.random((2, 30)).round(6)
    (away, steps), more = rng.random((2, 2, 30)), rng.random((2, 2, 30))
    pixels, some, used = rng.integers(3, 9, 30).astype(float), np.array([True, False]), rng.integers(0, 9, (5, 6)) / 1
    around, near = shown_around(np.array([[[0, 1], [3, 4]], [[2, 2], [6, 5]]]), twins)
    assert (near > 0).any()
    costs, worn = np.empty((2, 30)), 0.5 * (used.ravel() / pixels - used.mean())
    made = charges(missed, away, used, pixels, around, steps, more, only)
    most, luck, picked = np.array([3, 1]), np.array([0.1, 0.5]), np.empty((2, 3), int)
    picks = most, 0.4, 0.3, luck, costs, picked
    weigh(compared_as(found), made, valid, same, some, 0.05, 0.1, 0.7, *picks)
    alone = np.empty_like(picked)
    pick_each(costs, most, 0.4, 0.3, luck, alone)
    np.testing.assert_array_equal(picked, alone)
    for box in range(2):
        colors = found[box, 0] + missed[box]
        afforded = [attain(one, valid[box], same[box], 0.05, 0.1) for one in (colors, found[box, 1])]
        cost, shown = (colors + away[box]) / afforded[0], np.empty(30)
        charge_shown(worn, near[box], same[box], pixels, 0.3, 0.2, shown)
        if some[box]:
            cost = (cost + 0.7 * found[box, 1] / afforded[1]) / 1.7
            keep_in_step(steps[box], 0.25, only, valid[box], shown)
        np.testing.assert_allclose(costs[box], np.where(valid[box], cost + shown + more[:, box].sum(0), np.inf))
    none, _ = shown_around(np.empty((0, 2, 2), int), twins)
    made = charges(missed[:0], nothing, 0 * used, pixels, none, nothing, more[:0])
    for compared, colors in ((found[:, :1].copy(), found[:, 0]), (found[:0, :1].copy(), 0 * found[:, 0])):
        weigh(compared_as(compared), made, valid, same, some, 0.05, 0.1, 0.7, *picks)
        afforded = [attain(one, *rest, 0.05, 0.1) for one, *rest in zip(colors, valid, same, strict=True)]
        expected = colors / np.array(afforded)[:, None] + 0.3 * (same > 0)
        np.testing.assert_allclose(costs, np.where(valid, expected, np.inf))


def test_each_box_has_its_own_picks_or_draws_one():
    costs = np.random.default_rng(0).random((3, 20))
    picked, most, luck = np.empty((3, 4), int), np.array([4, 1, 3]), np.array([0.1, 0.5, 0.9])
    pick_each(costs, most, 0.1, 0.3, luck, picked)
    assert picked[1].tolist() == [draw(costs[1], 0.3, 0.5), -1, -1, -1]
    for box in (0, 2):
        chosen = pick(costs[box], most[box], 0.1)
        assert picked[box].tolist() == [*chosen, *[-1] * (4 - len(chosen))]


@pytest.mark.parametrize("most", [1, 4, 30])
def test_blocks_are_picked_by_their_cost_and_of_equals_the_first(most):
    costs = np.random.default_rng(most).integers(0, 9, 25) / 8
    costs[::4] = np.inf
    near = [i for i in np.argsort(costs, kind="stable") if costs[i] <= costs.min() + 0.5]
    np.testing.assert_array_equal(pick(costs, most, 0.5), near[:most])


def test_a_block_is_drawn_of_those_that_cost_about_the_least():
    costs = np.random.default_rng(0).integers(0, 9, 25) / 8
    costs[::4] = np.inf
    near = np.flatnonzero(costs <= costs.min() + 0.25)
    assert 1 < len(near) < 18
    for number, expected in enumerate(near):
        for luck in (number / len(near) + 1e-9, (number + 1) / len(near) - 1e-9):
            assert draw(costs, 0.25, luck) == expected
