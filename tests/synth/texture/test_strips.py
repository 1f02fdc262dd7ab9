"""Strips that cover holes in what runs along an axis: where they are laid, and that lines go on through them."""

import numpy as np
import pytest
import torch
from scipy import ndimage

from kwatra import Exemplar
from synth import fill
from synth.texture.strips import LENGTH, WIDTH, strips_along


def grain(side: int = 96, seed: int = 0) -> np.ndarray:
    """Fibers (side, side) that run down."""
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((side, side)), (16, 1))
    return (0.5 + 0.15 * noise / noise.std()).clip(0, 1).astype(np.float32)


def hole_in(shape: tuple[int, ...], rows: slice, columns: slice) -> np.ndarray:
    hole = np.zeros(shape, bool)
    hole[rows, columns] = True
    return hole


def test_strips_are_for_what_runs_along_an_axis_and_has_room_for_them() -> None:
    along = {
        axis: strips_along(Exemplar.of(torch.from_numpy(lines)[None]))
        for axis, lines in enumerate((grain(), grain().T.copy()))
    }
    assert along == {0: 0, 1: 1}
    noise = torch.rand(1, 96, 96, generator=torch.Generator().manual_seed(1))
    slanted = torch.sin(torch.arange(64.0) + 0.36 * torch.arange(64.0)[:, None])[None]  # by 20 degrees
    short = torch.from_numpy(grain())[None, : LENGTH - 1]
    for other in (noise, slanted, short):
        assert strips_along(Exemplar.of(other)) is None


@pytest.mark.parametrize("down", [True, False])
@pytest.mark.parametrize("seed", [0, 1])
def test_lines_that_are_alike_everywhere_are_restored(down: bool, seed: int) -> None:
    bars = np.random.default_rng(2).random(80, np.float32)
    lines = np.broadcast_to(bars, (150, 80))
    y, x = np.indices(lines.shape)
    hole = (y - 75) ** 2 + (x - 40) ** 2 < 400
    hole[:30, :3] = hole[100:105, 50:] = True  # at borders, too
    lines, hole = (lines, hole) if down else (lines.T, hole.T)
    filled = fill(np.where(hole, np.float32(0.9), lines), hole, seed=seed).image
    np.testing.assert_allclose(filled, lines, atol=1e-5)


def test_what_fills_comes_from_where_the_source_says_but_for_steps_that_are_spread() -> None:
    picture = grain(128)
    hole = hole_in(picture.shape, slice(40, 80), slice(50, 90))
    made = fill(picture, hole)
    assert np.array_equal(made.image[~hole], picture[~hole])
    assert not hole[tuple(made.source[1:, hole])].any()
    copied = made.take(picture)[hole]
    assert np.abs(copied - made.image[hole]).mean() < 0.2 * picture.std()
    again, other = fill(picture, hole), fill(picture, hole, seed=1)
    assert np.array_equal(again.image, made.image)
    assert not np.array_equal(other.image, made.image)


def test_a_hole_is_filled_from_another_picture_and_says_how_far_it_is() -> None:
    picture, parts = grain(96), list[float]()
    hole = hole_in(picture.shape, slice(10, 86), slice(20, 40))
    made = fill(picture, hole, exemplar=grain(128, 5), callback=lambda progress: parts.append(progress.fraction))
    assert np.array_equal(made.image[~hole], picture[~hole])
    assert (made.source[0, hole] == 0).all()
    assert made.source[1:, hole].max() < 128
    assert parts == sorted(parts)
    assert parts[-1] == 1
    steps = np.abs(np.diff(made.image, axis=0))[:, 20:40].mean(1)
    assert steps.max() < 0.3 * picture[:, 20:40].std()


def test_where_nothing_is_known_nothing_is_continued() -> None:
    made = fill(np.zeros((48, 40), np.float32), np.ones((48, 40), bool), exemplar=grain())
    assert made.result.stages
    assert made.image.std() > 0.5 * grain().std()


def test_a_hole_with_nothing_near_is_covered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("synth.texture.strips.NEAR", 32)
    picture = grain(192, 3)
    hole = hole_in(picture.shape, slice(40, 192), slice(3 * WIDTH, 189))
    filled = fill(np.where(hole, 9.0, picture), hole).image
    assert filled.max() < 1.2
