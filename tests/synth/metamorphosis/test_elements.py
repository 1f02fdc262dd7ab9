"""Elements of a texture: counted, parted, and not seen where there are none."""

import numpy as np
import pytest
from bench_patterns import made
from skimage import data

from synth.metamorphosis.elements import elements, of_mask, two_colors, without_specks


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


def test_a_flat_image_has_none_and_noise_is_not_sure() -> None:
    assert elements(np.full((40, 40, 3), 0.5)).count == 0
    assert not two_colors(np.full((40, 40, 3), 0.5)).any()
    grass = data.grass()[:96, :96, None] / 255
    assert elements(grass).sure < 0.18
