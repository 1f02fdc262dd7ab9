"""Borders between pictures: the cheapest there are, around elements, near where they are wanted."""

from itertools import product

import numpy as np
import pytest

from kwatra.pieces import HIDDEN
from synth.texture.borders import UNIT, WRONG, bordered

EVERYWHERE = [np.ones((3, 4), bool)] * 2
WANTED = np.array([[0, 0, 1, 1], [0, 1, 1, 1], [0, 0, 0, 1]])


def price(shown: np.ndarray, pictures: np.ndarray, depths: np.ndarray, unit: float, weight: float) -> float:
    """What is minimized, pixel by pixel."""
    total = WRONG * weight * (shown != WANTED).sum()
    height, width = shown.shape
    for y, x in product(range(height), range(width)):
        for v, u in ((y + 1, x), (y, x + 1)):
            if v < height and u < width and shown[y, x] != shown[v, u]:
                a, b = shown[y, x], shown[v, u]
                unlike = np.abs(pictures[a, :, [y, v], [x, u]] - pictures[b, :, [y, v], [x, u]]).sum()
                depth = (depths[a, y, x] + depths[b, v, u]) / 2
                total += (HIDDEN + (1 - HIDDEN) * depth) * unlike / unit
    return total


@pytest.mark.parametrize("seed", range(8))
def test_of_two_pictures_no_other_way_costs_less(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    pictures, depths = rng.random((2, 3, 3, 4)).astype(np.float32), rng.random((2, 3, 4)).astype(np.float32)
    unlike = np.abs(pictures[0] - pictures[1]).sum(0)
    down, across = WANTED[1:] != WANTED[:-1], WANTED[:, 1:] != WANTED[:, :-1]
    meet = [(unlike[1:] + unlike[:-1])[down], (unlike[:, 1:] + unlike[:, :-1])[across]]
    unit, weight = np.concatenate(meet).mean(), 20.0
    ways = (np.array(way).reshape(3, 4) for way in product([0, 1], repeat=12))
    least = min(price(way, pictures, depths, unit, weight) for way in ways)
    monkeypatch.setattr("synth.texture.borders._inner", lambda wanted: np.zeros(wanted.shape, bool))
    shown = bordered(WANTED, EVERYWHERE, pictures, depths, (False, False), weight)
    found = price(shown, pictures, depths, unit, weight)
    assert found <= 1.02 * least + 20 / UNIT  # a move that later borders share is not found for sure
    assert found <= price(WANTED, pictures, depths, unit, weight) + 20 / UNIT


def test_a_pixel_shows_what_is_wanted_or_near() -> None:
    pictures, depths = np.stack([np.zeros((1, 3, 4)), np.ones((1, 3, 4))]).astype(np.float32), np.ones((2, 3, 4))
    near = [np.zeros((3, 4), bool) for _ in range(2)]
    np.testing.assert_array_equal(bordered(WANTED, near, pictures, depths, (False, False), 1.0), WANTED)
    near[0][1, 1] = True  # a corner of the other, with three sides of border
    shorter = WANTED.copy()
    shorter[1, 1] = 0
    np.testing.assert_array_equal(bordered(WANTED, near, pictures, depths, (False, False), 1.0), shorter)


def test_a_border_goes_around_elements_as_far_as_the_weight_lets_it() -> None:
    size = 40
    rng = np.random.default_rng(0)
    pictures = rng.random((2, 3, size, size)).astype(np.float32)
    wanted = np.zeros((size, size), np.int64)
    wanted[:, 20:] = 1
    depths = np.zeros((2, size, size), np.float32)
    y, x = np.mgrid[:size, :size]
    inside = np.hypot(y - 20, x - 18) < 8  # an element of the left one, a third of which lies to the right
    depths[0][inside] = 1
    near = [np.ones((size, size), bool)] * 2
    light = bordered(wanted, near, pictures, depths, (False, False), 0.5)
    assert (light[inside] == 0).all()
    assert (light != wanted).mean() < 0.08
    heavy = bordered(wanted, near, pictures, depths, (False, False), 500.0)
    np.testing.assert_array_equal(heavy, wanted)


def test_no_place_is_given_up_however_cheap_that_is() -> None:
    wanted = np.zeros((40, 40), np.int64)
    wanted[10:20, 8:18] = wanted[30:34, 30:34] = 1
    wanted[:, 38:] = 2
    pictures = np.random.default_rng(0).random((3, 1, 40, 40)).astype(np.float32)
    near = [np.ones((40, 40), bool)] * 3
    shown = bordered(wanted, near, pictures, np.ones((3, 40, 40)), (False, False), 1e-4)
    assert (shown[13:17, 11:15] == 1).all()
    assert (shown[31:33, 31:33] == 1).all()
    assert (shown[:, 39] == 2).all()
    assert (shown != wanted).any()


def test_pictures_that_nowhere_meet_are_left_alone() -> None:
    pictures = np.zeros((1, 3, 5, 6), np.float32)
    shown = bordered(np.zeros((5, 6), np.int64), [np.ones((5, 6), bool)], pictures, pictures[:, 0], (True, True), 1.0)
    assert not shown.any()
