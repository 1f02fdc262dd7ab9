"""Which becomes which: against brute force, and orders of outlines."""

from itertools import permutations

import numpy as np
import pytest

from synth.metamorphosis.assignment import assigned
from synth.metamorphosis.patterns.correspondence import SEED, corresponding
from synth.metamorphosis.patterns.film import crowding, phases, touching
from synth.metamorphosis.patterns.outlines import alike, best_order, outline, resampled

SIZE = (96, 96)


def polygons(centers: np.ndarray, count: int = 8, radius: float = 6.0, turn: float = 0.0) -> np.ndarray:
    angles = turn + np.arange(count) / count * 2 * np.pi
    return centers[:, None] + radius * np.stack([np.cos(angles), np.sin(angles)], 1)


def lattice(pitch: int = 24) -> np.ndarray:
    x, y = np.meshgrid(np.arange(12, 96, pitch), np.arange(12, 96, pitch))
    return np.stack([x, y], -1).reshape(-1, 2).astype(float)


@pytest.mark.parametrize("count", range(1, 8))
def test_the_assignment_is_the_best_of_all(count: int) -> None:
    random = np.random.default_rng(count)
    a, b = random.uniform(0, 50, (count, 2)), random.uniform(0, 50, (7, 2))
    rows, columns = assigned(a, b)
    ours = np.square(a[rows] - b[columns]).sum()
    best = min(np.square(a - b[list(order)]).sum() for order in permutations(range(7), count))
    assert len(rows) == count
    assert ours == pytest.approx(best)


def test_the_surplus_grows_from_a_seed_between_its_neighbors() -> None:
    b = polygons(lattice())
    a = np.delete(b, 5, 0) + np.array([3.0, -2.0])
    ways = corresponding(a, b, SIZE, closed=False)
    assert ways.pairs == 15
    assert len(ways.in_a) == 16
    assert np.allclose(ways.in_b[-1], b[5])
    assert np.allclose(np.ptp(ways.in_a[-1], 0), SEED * np.ptp(b[5], 0))
    assert np.allclose(ways.in_a[-1].mean(0), b[5].mean(0) + np.array([3, -2]), atol=0.6)  # as its neighbors came


def test_what_is_left_over_in_a_shrinks() -> None:
    a = polygons(lattice())
    ways = corresponding(a, np.delete(a, 5, 0), SIZE, closed=False)
    assert np.allclose(ways.in_a[-1], a[5])
    assert np.allclose(np.ptp(ways.at(1.0)[-1], 0), SEED * np.ptp(a[5], 0))


def test_on_the_way_patterns_are_scaled_about_their_centroids() -> None:
    ways = corresponding(polygons(lattice()), polygons(lattice() + 4), SIZE, closed=False)
    assert np.allclose(ways.at(0.5, 0.5), polygons(lattice() + 2, radius=3.0))


def test_order_is_kept_where_it_is_given_and_found_where_it_is_free() -> None:
    a = polygons(lattice())
    b = np.roll(a, 3, 1)
    assert np.allclose(corresponding(a, b, SIZE, closed=False).in_b, b)
    assert np.allclose(corresponding(a, b, SIZE, closed=True).in_b, a)
    assert np.allclose(corresponding(a, b[:, ::-1], SIZE, closed=True).in_b, a)


def test_long_shapes_turn_and_round_ones_do_not() -> None:
    stretch = polygons(np.zeros((1, 2)), 16) * [4, 1]
    turned = stretch[..., ::-1][:, ::-1]
    fitted = turned[0][best_order(stretch, turned)[0]]
    # a similarity transform leads from one to the other: ratios of distances stay
    assert np.linalg.norm(fitted[0] - fitted[8]) == pytest.approx(np.linalg.norm(stretch[0, 0] - stretch[0, 8]))
    disc = polygons(np.zeros((1, 2)), 16)
    assert np.allclose(disc[0][best_order(disc, np.roll(disc, 5, 1))[0]], np.roll(disc[0], 5, 0)) is False
    assert np.allclose(np.roll(disc, 5, 1)[0][best_order(disc, np.roll(disc, 5, 1))[0]], disc[0])


def test_an_outline_runs_around_its_mask() -> None:
    x, y = np.meshgrid(np.arange(40), np.arange(40))
    found = outline(np.hypot(x - 20, y - 18) <= 10, 16)
    away = np.linalg.norm(found - [20, 18], axis=1)
    assert np.abs(away - 10.3).max() < 0.5
    assert found[0, 0] > 29
    assert found[4, 1] > 27  # clockwise on the screen: a quarter on, it is below


def test_outlines_are_sampled_to_the_count_of_the_other() -> None:
    square = np.array([[[0.0, 0], [4, 0], [4, 4], [0, 4]]])
    a, b = alike(square, polygons(lattice()), True, False)
    assert a.shape == (1, 8, 2)
    assert b.shape == (16, 8, 2)
    assert np.allclose(a[0], resampled(square[0], 8))
    assert np.allclose(a[0, :3], [[0, 0], [2, 0], [4, 0]])


def test_patterns_that_would_pass_through_each_other_are_crowded() -> None:
    centers = np.array([[30.0, 30], [50, 30]])
    meeting = corresponding(polygons(centers), polygons(centers), SIZE, closed=False)
    meeting.in_b[:] = meeting.in_a[::-1] + np.array([0, 1.0])
    apart = corresponding(polygons(centers), polygons(centers + 9), SIZE, closed=False)
    assert crowding(meeting) == 0.5
    assert crowding(apart) == 1


def test_crowded_patterns_shrink_then_move_then_grow() -> None:
    assert phases(0.3, 1.0) == (0.3, 1.0)
    assert phases(0.0, 0.5) == (0.0, 1.0)
    assert phases(0.1, 0.5) == (0.0, 0.75)
    assert phases(0.2, 0.5) == pytest.approx((0.0, 0.5))
    assert phases(0.5, 0.5) == pytest.approx((0.5, 0.5))
    assert phases(1.0, 0.5) == pytest.approx((1.0, 1.0))


def test_patterns_touch_where_most_are_nearer_than_a_cell() -> None:
    apart = polygons(lattice())  # 12 px between them
    near = polygons(lattice(), radius=10.5)
    assert not touching(corresponding(apart, apart, SIZE, closed=False))
    assert touching(corresponding(near, near, SIZE, closed=False))
    assert touching(corresponding(apart, near, SIZE, closed=False))
    assert not touching(corresponding(near[:1], near[:1], SIZE, closed=False))
