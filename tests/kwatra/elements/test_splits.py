"""Parts of pixels, ground that is cleaned of small ones, and the half of values that is most alike: by slower means."""

import numpy as np
import pytest
from scipy import ndimage

from kwatra.elements.alikeloops import find_half
from kwatra.elements.partloops import part
from kwatra.elements.splits import COVER, HOLE, LARGE, MANY, SMALL, SPECK, cleaned


def blotches(seed: int, share: float = 0.5, grain: float = 1.0, shape: tuple[int, int] = (37, 53)) -> np.ndarray:
    """Pixels of so many px or more at a time, of which a share is True."""
    smooth = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), grain)
    return smooth < np.quantile(smooth, share)


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("grain", [0.0, 0.6, 2.0])
@pytest.mark.parametrize("share", [0.0, 0.3, 0.55, 0.8, 1.0])
def test_pixels_that_hang_together_are_of_one_part(corners: bool, grain: float, share: float) -> None:
    pixels = blotches(3, share, grain)
    first, area = np.empty((2, pixels.size), np.int32)
    part(pixels, corners, first, area)
    number, count = ndimage.label(pixels, np.ones((3, 3)) if corners else None)
    flat = number.ravel()
    assert (first[flat == 0] == -1).all()
    for one in range(1, count + 1):
        there = np.flatnonzero(flat == one)
        assert (first[there] == there[0]).all()
        assert area[there[0]] == there.size
    assert area.sum() == pixels.sum()


def cleaned_slowly(split: np.ndarray, owner: np.ndarray, size: float) -> tuple[np.ndarray, float, float]:
    """Part by part, as it is described."""
    number, count = ndimage.label(split, np.ones((3, 3)))
    ground, inside, largest = np.zeros_like(split), owner >= 0, dict.fromkeys(np.unique(owner[owner >= 0]), 0)
    for one in range(1, count + 1):
        there = number == one
        ground |= there & (there.sum() >= HOLE * size**2)
        image = owner[there][0]
        largest[image] = max(largest[image], there.sum())
    number, count = ndimage.label(inside & ~ground)
    areas = [(number == one).sum() for one in range(1, count + 1)]
    for one, area in enumerate(areas, 1):
        ground |= (number == one) & (area < SPECK * size**2)
    like = [area for area in areas if SMALL * size**2 < area < LARGE * size**2]
    merged = sum(area for area in areas if area >= LARGE * size**2)
    few = min(1.0, len(like) / MANY) * min(1.0, sum(like) / inside.sum() / COVER)
    connected = sum(largest.values()) / max(split.sum(), 1)
    return ground, connected * few * sum(like) / max(sum(like) + merged, 1), merged / inside.sum()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("size", [4.0, 7.5, 12.0])
def test_ground_is_cleaned_as_if_part_by_part(seed: int, size: float) -> None:
    owner = np.zeros((37, 53), np.int64)
    if seed % 2:  # two images, apart
        owner[:, 30:], owner[:, 26:30], owner[20:24] = 1, -1, -1
        owner[24:, :26] = 2
    split = blotches(seed, 0.2 + 0.1 * (seed % 3), 0.5 * (1 + seed // 2)) & (owner >= 0)
    ground, *figures = cleaned(split, owner, size)
    expected, *told = cleaned_slowly(split, owner, size)
    np.testing.assert_array_equal(ground, expected)
    assert figures == pytest.approx(told, abs=1e-12)


def test_where_nothing_is_ground_that_is_not_sure_at_all() -> None:
    nothing = np.zeros((20, 20), bool)
    ground, sure, merged = cleaned(nothing, np.zeros((20, 20), np.int64), 5.0)
    assert not ground.any()
    assert (sure, merged) == (0.0, 1.0)


def test_the_half_that_is_most_alike_is_where_steps_lead() -> None:
    rng = np.random.default_rng(1)
    common = rng.normal(size=(3, 300)) * np.array([0.2, 1.0, 0.5])[:, None]
    values = np.ascontiguousarray(np.concatenate([common, rng.normal(4, 2, (3, 200))], 1)[:, rng.permutation(500)])
    start, middle, varied = np.array([0.3, 0.0]), np.empty(3), np.empty((3, 3))
    find_half(values, start, 30, 1e-4, middle, varied)
    away, before = np.square(values[:2] - start[:, None]).sum(0), None
    for _ in range(30):
        half = away <= np.median(away)
        if before is not None and (half == before).all():
            break
        mean, covariance = values[:, half].mean(1), np.cov(values[:, half], bias=True) + 1e-4 * np.eye(3)
        apart = values - mean[:, None]
        before, away = half, (apart * np.linalg.solve(covariance, apart)).sum(0)
    np.testing.assert_allclose(middle, mean, atol=1e-12)
    np.testing.assert_allclose(varied, covariance, atol=1e-12)
    assert np.abs(middle).max() < 0.3  # of what is common
