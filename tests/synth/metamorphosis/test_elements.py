"""Elements of a texture: counted, parted, and not seen where there are none."""

import numpy as np
import pytest
from bench_patterns import made
from skimage import data

from synth.metamorphosis.elements import elements, of_mask, two_colors, without_specks
from synth.metamorphosis.patterns.finding import SURE


def discs(centers: list[tuple[int, int]], radius: int, size: int = 96) -> np.ndarray:
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    return np.any([np.hypot(x - cx, y - cy) <= radius for cx, cy in centers], axis=0)


@pytest.mark.parametrize("kind", ["disc", "cross"])
def test_made_elements_are_counted(kind: str) -> None:
    texture = made(kind, noise=0.03)
    assert abs(elements(texture.image).count - len(texture.landmarks)) <= 1


def test_elements_have_their_pixels_in_either_polarity() -> None:
    mask = discs([(20, 20), (60, 20), (20, 60), (60, 60)], 10)
    for bright in (mask, ~mask):
        image = np.repeat(np.where(bright, 0.8, 0.2)[..., None], 3, 2)
        found = elements(image)
        assert found.count == 4
        assert (found.mask != mask).mean() < 0.03


def test_discs_that_touch_are_parted() -> None:
    mask = discs([(30, 40), (50, 40)], 10)
    assert of_mask(mask, mask[..., None].astype(float)).count == 2


def test_specks_and_pinholes_go() -> None:
    mask = discs([(30, 40)], 10)
    speckled = mask.copy()
    speckled[80, 80] = True
    speckled[40, 30] = False
    assert np.array_equal(without_specks(speckled), mask)


def test_two_colors_of_one_brightness_are_told_apart() -> None:
    mask = discs([(30, 40), (70, 70)], 12)
    colors = [0.7, 0.2, 0.3], [0.1, 0.2, 0.9]
    for inside, outside in (colors, colors[::-1]):
        assert np.array_equal(two_colors(np.where(mask[..., None], inside, outside)), mask)


def test_colors_of_exactly_one_brightness_are_told_apart() -> None:
    mask = discs([(20, 20), (60, 20), (20, 60), (60, 60)], 10)
    found = elements(np.where(mask[..., None], [0.75, 0.25, 0.5], [0.25, 0.75, 0.5]))
    assert found.count == 4
    assert (found.mask != mask).mean() < 0.03


@pytest.mark.parametrize("light", [False, True])
def test_elements_of_two_tones_on_one_ground_are_all_found(light: bool) -> None:
    """Two classes part bright elements from all else, and all around those is brighter than the others are."""
    centers = [(12 + 24 * column, 12 + 24 * row) for column in range(4) for row in range(4)]
    image = np.full((96, 96, 3), 0.1)
    for number, center in enumerate(centers):
        image[discs([center], 11)] = 0.3 if (number + number // 4) % 2 else 0.9
    found = elements(1 - image if light else image)
    assert found.count == 16
    assert (found.mask != discs(centers, 11)).mean() < 0.08


def test_a_flat_image_has_none_and_noise_is_not_sure() -> None:
    flat = np.broadcast_to([0.8, 0.5, 0.2], (40, 40, 3))
    assert not two_colors(flat).any()
    assert elements(flat).count == 0
    assert not elements(flat + discs([(10, 10), (30, 30)], 6, 40)[..., None] * 5e-4).sure
    grass = data.grass()[:96, :96, None] / 255
    assert elements(grass).sure < SURE
