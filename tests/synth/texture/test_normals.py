"""Normal maps: directions turn with the pieces that are mirrored or turned, and nothing else changes."""

import numpy as np
import pytest

from synth import synthesize
from synth.texture.maps import rearranged
from synth.texture.normals import MIRRORED, coded, decoded, is_normal, points_down, turned_normals

BUMPS = np.random.default_rng(0).random((12, 12))


def surface(size: int = 72) -> np.ndarray:
    """A height map of bumps, smooth and irregular, (size, size) in [0, 1]."""
    rows, columns = np.mgrid[:size, :size]
    waves = sum(
        np.sin(0.55 * rows * np.cos(a) + 0.55 * columns * np.sin(a) + 6 * p) for a, p in BUMPS[:, :2] * [[3.14, 1]]
    )
    return (waves - waves.min()) / (waves.max() - waves.min())


def normals_of(height: np.ndarray, down: bool = False) -> np.ndarray:
    """The normals (H, W, 3) uint8 of a height map, y up unless asked otherwise."""
    slope_y, slope_x = np.gradient(4 * height)
    normal = np.stack([-slope_x, -slope_y if down else slope_y, np.ones_like(height)], -1)
    return np.rint((normal / np.linalg.norm(normal, axis=-1, keepdims=True) + 1) * 127.5).astype(np.uint8)


def off(made: np.ndarray, height: np.ndarray, where: np.ndarray, down: bool) -> float:
    """The mean error of x and y, in [-1, 1], against the normals of the height map that was made with them."""
    return float(np.mean(np.abs(made[where][:, :2] / 127.5 - normals_of(height, down)[where][:, :2] / 127.5)))


@pytest.mark.parametrize("down", [False, True])
@pytest.mark.parametrize("options", [{"mirror": True}, {"rotate": (90, 180, 270)}, {"rotate": (30, 75)}])
def test_normals_are_those_of_the_height_that_was_made(options: dict, down: bool) -> None:
    height = surface()
    image = np.rint(255 * height).astype(np.uint8)
    made = synthesize(image, (96, 96), seed=2, preset="fast", **options)
    assert made.turns is not None
    copied = (made.turns != np.eye(2)[..., None, None]).any((0, 1))
    assert copied.mean() > 0.05
    there = made.image / 255
    turned = made.take_normals(normals_of(height, down), down)
    error = off(turned, there, copied, down)
    assert error < 0.06
    assert off(made.take(normals_of(height, down)), there, copied, down) > 2 * error
    assert (turned[~copied] == made.take(normals_of(height, down))[~copied]).all()


def test_without_variants_nothing_is_turned() -> None:
    image = np.rint(255 * surface(48)).astype(np.uint8)
    made = synthesize(image, (48, 48), preset="fast", scale=(0.8,))
    assert made.turns is None
    assert (made.take_normals(normals_of(surface(48))) == made.take(normals_of(surface(48)))).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_quarter_turns_are_exact_and_other_channels_stay(dtype: type) -> None:
    most = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1.0
    values = (np.random.default_rng(1).random((4, 5, 4)) * most).astype(dtype)
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])  # counterclockwise: what pointed right points up
    turns = np.broadcast_to(quarter[..., None, None], (2, 2, 4, 5))
    made = turned_normals(values, turns)
    np.testing.assert_allclose(made[..., 1], values[..., 0], rtol=1e-6)
    np.testing.assert_allclose(made[..., 0], most - values[..., 1], rtol=1e-6)
    assert (made[..., 2:] == values[..., 2:]).all()
    assert made.dtype == dtype
    again = turned_normals(turned_normals(turned_normals(made, turns), turns), turns)
    np.testing.assert_allclose(again, values, atol=most * 1e-6)


def test_floats_below_zero_are_about_zero() -> None:
    values = np.array([[[0.5, -0.25, 0.8]]], np.float32)
    half = np.broadcast_to(-np.eye(2)[..., None, None], (2, 2, 1, 1))
    assert turned_normals(values, half).ravel().tolist() == pytest.approx([-0.5, 0.25, 0.8])


def test_its_name_says_what_a_map_holds() -> None:
    names = ("normal", "Normals", "normal_gl", "NormalDX", "brick_normal", "height", "abnormal")
    assert list(filter(is_normal, names)) == list(names[:5])
    assert points_down("NormalDX")
    assert not points_down("normal")
    values = np.array([[[10, 20, 30]]], np.uint8)
    source, half = np.zeros((3, 1, 1), int), np.broadcast_to(-np.eye(2)[..., None, None], (2, 2, 1, 1))
    assert rearranged("normal", [values], source, half).ravel().tolist() == [245, 235, 30]
    assert rearranged("height", [values], source, half).ravel().tolist() == [10, 20, 30]


def test_turns_are_kept_as_whole_numbers() -> None:
    quarter, mirror = np.array([[0.0, 1.0], [-1.0, 0.0]]), np.diag([-1.0, 1.0])
    matrices = np.stack([np.eye(2), quarter, mirror, quarter @ mirror], -1)[:, :, None]
    assert coded(matrices).tolist() == [[0, 90_000, MIRRORED, MIRRORED + 90_000]]
    assert (decoded(coded(matrices)) == matrices).all()
    angle = np.radians(33.3)
    some = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])[:, :, None, None]
    np.testing.assert_allclose(decoded(coded(some)), some, atol=1e-6)
