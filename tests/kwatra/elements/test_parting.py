"""Parts of a picture: how much they differ, and where they meet."""

import numpy as np
import pytest
from scipy import ndimage

from kwatra.elements.contrast import NARROW, against_around
from kwatra.elements.parting import between_parts, deviations, meeting, touching, usual_area


def test_what_lies_between_parts_of_one_color_each_is_all_and_of_equal_ones_nothing() -> None:
    number = np.arange(12)[:, None] // 4 * 3 + np.arange(12) // 4 + 1
    inside = np.ones((12, 12), bool)
    flat = np.stack([number * 0.1, 1.0 - number * 0.05])
    assert between_parts(flat, number, inside) == pytest.approx(1)
    same = np.indices((12, 12)).astype(float) % 4
    assert between_parts(same, number, inside) == pytest.approx(0)
    rng = np.random.default_rng(0)
    noisy = flat + rng.normal(0, 0.2, (2, 12, 12))
    means = np.stack([channel[number == k].mean() * np.ones(16) for channel in noisy for k in range(1, 10)])
    expected = means.reshape(2, -1).var(1).sum() / noisy.reshape(2, -1).var(1).sum()
    assert between_parts(noisy, number, inside) == pytest.approx(expected)
    assert between_parts(noisy, np.zeros((12, 12), int), inside) == 0
    assert between_parts(np.full((1, 12, 12), 0.5), number, inside) == 0


def test_parts_meet_where_values_are_least_and_small_ones_are_ground() -> None:
    ground = np.zeros((20, 31), bool)
    ground[:, 8:14] = ground[:, 20:26] = True
    ground[8:12, 2:28] = True
    ground[10, 17] = False
    values = np.where(np.isin(np.arange(31), (10, 21)), -1.0, 0.0) * np.ones((20, 1))
    values[ground & (values == 0)] = -0.5
    values[np.isin(np.arange(20), (9, 10))] -= 0.1
    parts = meeting(ground, values, np.ones_like(ground), 2)
    assert len(np.unique(parts)) == 1 + 4  # what is outside hangs together at the ends of the cross
    assert len(np.unique(meeting(ground, values, np.ones_like(ground), 1))) == 1 + 5
    assert (parts[:8, [10, 21]] == 0).all()
    assert (parts[5, :10] == parts[5, 0]).all()
    assert (parts[5, 11:21] == parts[5, 15]).all()
    labels, count = ndimage.label(parts > 0)
    assert count == 4
    assert all(len(np.unique(parts[labels == k])) == 1 for k in range(1, count + 1))


def test_narrow_valleys_stand_out_however_bright_what_is_beside_them() -> None:
    bright = np.repeat(np.linspace(0.3, 0.9, 5), 12) * np.ones((40, 1))
    joints = np.isin(np.arange(60) % 12, (0, 1))
    image = np.where(joints, bright - 0.3, bright)
    for colors, number in ((image, 0), (1 - image, 1)):
        values = list(against_around(colors[None], np.ones_like(image, bool), 12))[number]
        inner = values[:, 2:-2]
        assert inner[:, joints[2:-2]].max() < -0.08
        assert inner[:, ~joints[2:-2] & ~np.isin(np.arange(60) % 12, (2, 11))[2:-2]].min() > -0.01
    assert NARROW * 12 > 2


def test_deviations_count_each_direction_in_how_much_varies_along_it() -> None:
    rng = np.random.default_rng(0)
    mixing, middle = rng.normal(size=(3, 3)), rng.normal(size=3)
    even = rng.normal(size=(3, 5, 7))
    values = np.einsum("ij,jyx->iyx", mixing, even) + middle[:, None, None]
    found = deviations(values, middle, mixing @ mixing.T)
    np.testing.assert_allclose(found, np.linalg.norm(even, axis=0))
    np.testing.assert_allclose(found.ravel(), deviations(values.reshape(3, -1), middle, mixing @ mixing.T))


def test_parts_touch_where_two_that_are_parts_differ_along_an_axis() -> None:
    parts = np.array([[1, 1, 2], [0, 1, 2], [3, 0, 2]])
    found = {
        (tuple(np.argwhere(meet)[k].tolist()), axis)
        for axis, (_, _, meet) in enumerate(touching(parts))
        for k in range(np.count_nonzero(meet))
    }
    assert found == {((0, 1), 1), ((1, 1), 1)}  # 1 beside 2, in two rows; 3 meets none
    numbers = np.arange(9).reshape(3, 3)
    steps = [numbers[index] - numbers[before] for index, before, _ in touching(parts)]
    assert [np.unique(step).tolist() for step in steps] == [[3], [1]]


def test_the_usual_area_is_that_of_the_part_of_the_middle_pixel() -> None:
    assert usual_area(np.array([1, 1, 1, 1, 10, 30])) == 30
    assert usual_area(np.array([10, 1, 1, 12])) == 10
    assert usual_area(np.array([0, 5, 0])) == 5
    assert usual_area(np.empty(0)) == 1
