"""Elements scattered on ground that is a texture of its own."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements
from made import MADE
from scipy import ndimage

from kwatra import Exemplar
from kwatra.elements import find_ground
from kwatra.elements.scattered import unlike_most
from kwatra.elements.splits import Picture
from synth import synthesize


def speckled(share: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Colors (3, 96, 96) that vary, and which of them, of a share about, are smoother and of other colors."""
    rng = np.random.default_rng(seed)
    smooth = ndimage.gaussian_filter(rng.normal(0, 1, (96, 96)), 6)
    other = smooth > np.quantile(smooth, 1 - share)
    colors = 0.5 + 0.12 * rng.normal(0, 1, (1, 96, 96)) * np.array([1.0, 0.9, 0.7])[:, None, None]
    shades = 0.5 + 0.3 * np.sign(ndimage.gaussian_filter(rng.normal(0, 1, (3, 96, 96)), (0, 4, 4)))
    return np.where(other, shades, colors), other


@pytest.mark.parametrize("share", [0.1, 0.25, 0.4])
def test_what_is_unlike_most_is_far_from_it(share: float) -> None:
    colors, other = speckled(share)
    unlike = unlike_most(colors, np.ones(other.shape, bool))
    assert (unlike <= 1).mean() == pytest.approx(0.5, abs=0.01)
    well_within = ndimage.binary_erosion(other, iterations=3)
    assert (unlike[well_within] > 3).mean() > 0.97
    assert (unlike[~ndimage.binary_dilation(other, iterations=3)] < 2.5).mean() > 0.97


def test_each_direction_counts_by_how_most_vary_along_it() -> None:
    """Stretched along one channel, and moved, all are as far as before."""
    colors, other = speckled(0.2)
    inside, even = np.ones(other.shape, bool), colors.copy()
    even[1] = 0.25 * even[1]
    one, two = (unlike_most(each + 0.05 * colors.mean(0), inside) for each in (colors, even))
    assert np.corrcoef(one[one < 3], two[one < 3])[0, 1] > 0.9


def test_what_is_outside_has_no_influence() -> None:
    colors, other = speckled(0.2)
    inside = np.ones(other.shape, bool)
    inside[20:40, 10:60] = False
    found = [unlike_most(np.where(inside, colors, value), inside) for value in (0.0, 1.0)]
    np.testing.assert_array_equal(found[0], found[1])
    assert np.isinf(found[0][~inside]).all()
    assert np.isfinite(found[0][inside]).all()


def test_most_of_one_color_are_not_unlike_at_all() -> None:
    assert unlike_most(np.full((3, 20, 20), 0.5), np.ones((20, 20), bool)).max() <= 1 + 1e-6
    colors = np.full((1, 20, 20), 0.5)
    colors[:, 4:8, 4:8] = 0.9
    unlike = unlike_most(colors, np.ones((20, 20), bool))
    assert unlike[5, 5] > 100
    assert unlike[15, 15] <= 1


def test_a_few_pixels_are_enough() -> None:
    inside = np.zeros((9, 9), bool)
    inside[4, 3:6] = True
    assert np.isfinite(unlike_most(np.random.default_rng(0).random((3, 9, 9)), inside)[inside]).all()


@pytest.mark.parametrize(("size", "gray"), [(20, False), (28, False), (32, True)])
def test_sand_is_ground_beneath_pebbles_as_dark_and_as_light_as_it_is(size: int, gray: bool) -> None:
    made = MADE["beach"](128, size, 1)
    truth, image = made.numbers.numpy() == 0, made.image.mean(0, keepdim=True) if gray else made.image
    found = find_ground(Exemplar.of(image))
    ground = found.depth == 0
    assert found.hides > 0.95
    assert found.size == pytest.approx(1.35 * size, rel=0.15)
    assert 2 * (ground & truth).sum() > (0.8 if gray else 0.9) * (ground.sum() + truth.sum())
    assert truth[ground].mean() > 0.9


def test_pebbles_on_sand_stay_whole() -> None:
    made = MADE["beach"](128, 24, 1)
    places = np.arange(128 * 128).reshape(128, 128)
    shown = synthesize(made.image, (256, 256), seed=2).take(places)
    assert cut_elements(made.numbers.numpy(), shown)["cut"] <= 0.05  # .3 where sand is no ground


def test_what_is_most_of_a_picture_with_no_elements_is_no_ground() -> None:
    noise = torch.from_numpy(np.random.default_rng(3).normal(0.5, 0.1, (3, 96, 96)).clip(0, 1)).float()
    assert find_ground(Exemplar.of(noise)).hides < 0.1


@pytest.mark.parametrize("seed", [1, 2])
def test_flat_stones_of_two_colors_are_no_ground_though_they_are_half_of_the_picture(seed: int) -> None:
    assert find_ground(Exemplar.of(MADE["patches"](128, 20, seed).image)).hides < 0.5


def test_uneven_ground_is_told_by_its_colors_from_far() -> None:
    rng, rows = np.random.default_rng(0), np.arange(96)[:, None] // 48
    rough, halves = rng.random((96, 96)), 0.5 * np.broadcast_to(rows, (96, 96))
    ground = rng.random((96, 96)) < 0.8
    for colors, expected in ((rough, 0.0), (halves, 0.92)):  # they run into each other along one line
        picture = Picture(Exemplar.of(torch.from_numpy(colors)[None].float()))
        assert picture.uneven(ground, 4.0) == pytest.approx(expected, abs=0.06)
