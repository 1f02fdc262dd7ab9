"""Fits by FFT against sums counted one by one."""

import numpy as np
import pytest

from kwatra.pieces import Fit, totals

SHAPES = [((7, 9), (3, 4)), ((5, 6, 7), (2, 3, 3)), ((6, 6), (6, 6))]


def windows(image: np.ndarray, extent: tuple[int, ...]) -> np.ndarray:
    """Every window of an image (C, *S), (*room, C, *extent)."""
    axes = tuple(range(1, image.ndim))
    return np.moveaxis(np.lib.stride_tricks.sliding_window_view(image, extent, axes), 0, len(extent))


@pytest.mark.parametrize(("shape", "extent"), SHAPES)
@pytest.mark.parametrize("per_channel", [False, True])
def test_a_region_is_compared_with_every_place_of_the_image(
    shape: tuple[int, ...], extent: tuple[int, ...], per_channel: bool
) -> None:
    rng = np.random.default_rng(0)
    image, content = rng.random((2, *shape)), rng.random((2, *extent))
    weight = rng.random((2, *extent) if per_channel else extent) * (rng.random(extent) < 0.7)
    expected = (weight * (windows(image, extent) - content) ** 2).sum(tuple(range(-len(extent) - 1, 0)))
    fit = Fit(image)
    np.testing.assert_allclose(fit.inside(content, weight), expected, atol=1e-9)
    content[:, weight.reshape(-1, *extent).max(0) == 0] = np.nan  # what has no weight is not looked at
    np.testing.assert_allclose(fit.inside(content, weight), expected, atol=1e-9)


def test_images_that_are_placed_together_are_compared_each_for_itself() -> None:
    rng = np.random.default_rng(2)
    image, other, weight = rng.random((2, 7, 9)), rng.random((1, 7, 9)), rng.random((2, 1, 3, 4))
    ones = np.concatenate([rng.random((2, 3, 3, 4)) * weight, weight], 1)
    found = Fit(image, other).less_energy(ones)
    assert found.shape == (2, 2, 5, 6)
    np.testing.assert_allclose(found[:, :1], Fit(image).less_energy(ones[:, [0, 1, 3]]), atol=1e-9)
    np.testing.assert_allclose(found[:, 1:], Fit(other).less_energy(ones[:, [2, 3]]), atol=1e-9)


@pytest.mark.parametrize(("shape", "extent"), SHAPES)
def test_the_image_is_compared_with_every_part_of_a_stretch(shape: tuple[int, ...], extent: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    mask = (rng.random(shape) < 0.6).astype(float)
    image, stretch = rng.random((3, *extent)), rng.random((3, *shape)) * mask
    cost, count = Fit(image).under(stretch, mask)
    axes = tuple(range(-len(extent) - 1, 0))
    there = windows(mask[None], extent)
    expected = (there * (windows(stretch, extent) - image) ** 2).sum(axes)
    np.testing.assert_allclose(cost, expected, atol=1e-9)
    np.testing.assert_array_equal(count, there.sum(axes))
    np.testing.assert_allclose(totals(image[0], mask), (there * image[0]).sum(axes), atol=1e-9)
    np.testing.assert_allclose(totals(image, mask), [(there * plane).sum(axes) for plane in image], atol=1e-9)
