"""Pictures that tile: the inside stays, no seam is left, maps go along, periods are held."""

import numpy as np
import pytest
import torch
from bench_elements import cut_elements
from made import MADE
from scipy import ndimage
from skimage import data

from kwatra import InputError
from kwatra.pieces import hidden_seams
from synth import Synthesis, tile
from synth.texture import whole_size


def wrapped_step(image: np.ndarray, axis: int) -> float:
    """Mean difference between the last row (or column) and the first."""
    image = image.astype(float)
    return float(np.abs(image.take(0, axis) - image.take(-1, axis)).mean())


def usual_step(image: np.ndarray, axis: int) -> float:
    return float(np.abs(np.diff(image.astype(float), axis=axis)).mean())


def test_gravel_meets_itself_like_gravel_and_its_inside_stays() -> None:
    gravel = data.gravel()[20:116, 30:142]
    made = tile(gravel, band=12)
    assert made.image.dtype == np.uint8
    assert made.image.shape == gravel.shape
    assert np.array_equal(made.image[12:-12, 12:-12], gravel[12:-12, 12:-12])
    for axis in (0, 1):
        assert wrapped_step(gravel, axis) > 1.5 * usual_step(gravel, axis)
        assert wrapped_step(made.image, axis) < 1.2 * usual_step(gravel, axis)
    assert 0 < (made.image != gravel).mean() < 0.4


def test_what_is_not_blended_comes_from_where_the_source_says_and_maps_go_along() -> None:
    gravel = data.gravel()[:80, :96].astype(np.uint16) * 257
    made = tile(gravel)
    moved = made.take(gravel)
    assert made.image.dtype == np.uint16
    assert np.mean(moved == made.image) > 0.75
    assert np.abs(moved.astype(float) - made.image).mean() < 0.02 * 65535
    assert not made.source[0].any()
    place = np.indices(gravel.shape)
    assert np.array_equal(made.source[1:, 20:-20, 20:-20], place[:, 20:-20, 20:-20])
    assert wrapped_step(moved, 0) < 1.5 * usual_step(gravel, 0)


def test_a_picture_that_tiles_already_stays_nearly_as_it_is() -> None:
    y, x = np.mgrid[:64, :96]
    image = 0.5 + 0.25 * np.sin(2 * np.pi * x / 24) + 0.25 * np.sin(2 * np.pi * y / 16)
    made = tile(image)
    assert np.abs(made.image - image).max() < 1e-3


def test_along_one_axis_the_other_borders_stay() -> None:
    gravel = torch.from_numpy(data.gravel()[:80, :96]).float()[None] / 255
    made = tile(gravel, axes="x", band=12.0)  # whole, of whatever type
    assert torch.equal(made.image[:, :, 12:-12], gravel[:, :, 12:-12])
    assert not torch.equal(made.image[:, :, :12], gravel[:, :, :12])
    assert wrapped_step(made.image[0].numpy(), 1) < 1.2 * usual_step(gravel[0].numpy(), 1)
    assert wrapped_step(made.image[0].numpy(), 0) > 1.5 * usual_step(gravel[0].numpy(), 0)


def test_light_that_changes_across_the_picture_leaves_no_step() -> None:
    light = np.linspace(0.6, 1.0, 128)
    noise = np.random.default_rng(0).normal(0.5, 0.02, (48, 128))
    made = tile((noise * light).astype(np.float32), band=12, axes="x")
    blurred = made.image.mean(0)
    steps = np.abs(np.diff(np.concatenate([blurred, blurred[:1]])))
    assert steps.max() < 0.06  # of 0.2 between the borders


def test_light_that_falls_unevenly_is_taken_out_of_all_of_a_tile() -> None:
    even = data.gravel()[:160, :160] / 255
    lit = even * np.linspace(0.6, 1.4, 160)[:, None] * 0.7
    made = tile(lit, band=12)
    here, rows = made.image[20:-20, 20:-20], lit[20:-20, 20:-20]
    assert np.abs(here.mean(1)[:20].mean() - here.mean(1)[-20:].mean()) < 0.03
    assert np.abs(rows.mean(1)[:20].mean() - rows.mean(1)[-20:].mean()) > 0.15
    assert np.corrcoef(here.ravel(), even[20:-20, 20:-20].ravel())[0, 1] > 0.98
    assert np.array_equal(made.even[0][20:-20, 20:-20], here)
    assert np.array_equal(made.take(lit)[20:-20, 20:-20], rows)


def test_light_that_changes_along_the_borders_that_meet_stays() -> None:
    lit = data.gravel()[:160, :160] / 255 * np.linspace(0.6, 1.4, 160)[:, None] * 0.7
    down, across = tile(lit, band=12, axes="y").image, tile(lit, band=12, axes="x").image
    assert np.abs(down[:40].mean() - down[-40:].mean()) < 0.03
    assert across[-40:].mean() - across[:40].mean() > 0.15


@pytest.mark.parametrize("seed", [0, 1])
def test_fibers_end_in_no_line(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(seed).standard_normal((96, 96))
    runs = ndimage.gaussian_filter(noise, (1.0, 12.0), mode="nearest")
    fibers = (0.5 + 0.15 * runs / runs.std()).clip(0, 1).astype(np.float32)

    def steepest() -> float:
        """The steepest step of the tile from a column to the next."""
        made = tile(fibers, axes="x").image
        return float(np.abs(made - np.roll(made, 1, 1)).mean(0).max())

    now = steepest()
    monkeypatch.setattr("synth.texture.sewing.runs_along", lambda anisotropy, least: None)
    assert now < 0.8 * steepest()


def test_cropped_to_whole_periods() -> None:
    y, x = np.mgrid[:100, :110]
    dots = (np.hypot((y + 3) % 16 - 8, (x + 5) % 20 - 10) < 5).astype(np.float64)
    dots += np.random.default_rng(0).normal(0, 0.02, dots.shape)
    picture = torch.from_numpy(dots)[None].float()
    assert whole_size([picture], (100, 110), crop=True) == (96, 100)
    assert whole_size([picture], (90, 130)) == (96, 120)
    assert whole_size([picture], (48, 40)) == (48, 40)
    assert whole_size([picture], (90, 110), "x") == (90, 100)
    assert whole_size([torch.rand(1, 64, 64, generator=torch.Generator().manual_seed(0))], (64, 64)) is None
    assert whole_size([picture.repeat(1, 8, 5)], (90, 130), quickly=True) is None
    made = tile(dots, crop=True)
    assert made.image.shape == (96, 100)
    assert np.mean((np.roll(made.image, (16, 20), (0, 1)) > 0.5) != (made.image > 0.5)) < 0.01
    top, left = made.source[1, 40, 40] - 40, made.source[2, 40, 40] - 40
    assert np.array_equal(made.image[20:-20, 20:-20], dots[top : top + 96, left : left + 100][20:-20, 20:-20])


def test_rows_tile_in_whole_courses_and_in_any_length_along_them():
    letters = MADE["letters"](128, 20, 0).image  # lines 24 px apart
    assert whole_size([letters], (100, 107)) == (96, 107)
    assert whole_size([letters], (100, 107), "x") == (100, 107)
    assert whole_size([letters], (130, 128), crop=True) == (120, 128)
    assert whole_size([letters.transpose(1, 2)], (107, 100)) == (107, 96)


def test_cloth_has_whole_cells_to_the_pixel():
    lines = torch.tensor([0.1] * 5 + [0.9] * 8 + [0.4] * 11 + [0.65] * 7 + [0.2] * 17)
    cloth = (lines[:, None] + lines)[None] / 2
    assert whole_size([cloth], (100, 130)) == (96, 144)
    assert whole_size([cloth], (100, 130), crop=True) == (96, 96)
    assert whole_size([cloth], (97, 96), "x") == (97, 96)
    assert whole_size([cloth], (30, 96)) is None


def test_the_same_seed_gives_the_same_bits_and_another_another() -> None:
    gravel = data.gravel()[:48, :48]
    a, b, c = (tile(gravel, seed=seed).image for seed in (0, 0, 1))
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axes": "z"}, "axes is 'z'"),
        ({"band": 1}, "the band is 1 pixels; of 64x48 it is a whole number from 2 to 12"),
        ({"band": 3.5}, "the band is 3.5 pixels"),
        ({"band": 13}, "the band is 13 pixels"),
        ({"image": np.zeros((12, 64))}, "the picture is 64x12; at least 16x16"),
        ({"crop": True}, "no period was found"),
        ({"image": np.full((64, 64), np.nan)}, "NaN"),
    ],
)
def test_bad_requests_are_refused(options: dict, message: str) -> None:
    image = np.random.default_rng(0).random((48, 64))
    with pytest.raises(InputError, match=message):
        tile(**({"image": image} | options))


def test_a_video_is_refused():
    with pytest.raises(InputError, match=r"the picture has shape \(8, 24, 24, 1\), as videos have; give an image"):
        tile(np.zeros((8, 24, 24, 1), np.uint8))


def rolled(made: Synthesis, side: int) -> np.ndarray:
    """From where each pixel of a tile comes, its borders in the middle."""
    row, column = np.asarray(made.source[-2:]).astype(int)
    return np.roll(row * side + column, (side // 2, side // 2), (0, 1))


@pytest.mark.parametrize(("name", "most"), [("stones", 0.4), ("coins", 0.5), ("patches", 0.5)])
def test_elements_stay_whole_where_a_picture_meets_itself(
    name: str, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures, mixed = [MADE[name](128, 20, seed) for seed in range(2)], []
    for hides in (hidden_seams, lambda exemplar: None):
        monkeypatch.setattr("synth.texture.sewing.hidden_seams", hides)
        tiles = [rolled(tile(made.image), 128) for made in pictures]
        cut = [
            cut_elements(made.numbers.numpy(), where, made.touching)
            for made, where in zip(pictures, tiles, strict=True)
        ]
        mixed.append(sum(figures["mixed"] for figures in cut))
    assert mixed[0] < most * mixed[1]


def test_colors_do_not_run_across_hidden_seams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of flat cells without noise, whose outlines hide seams, few pixels have another color than the four."""
    rows, number = torch.arange(96) // 12, torch.randint(4, (8, 8), generator=torch.Generator().manual_seed(1))
    colors = torch.tensor([[0.8, 0.2, 0.2], [0.2, 0.6, 0.3], [0.2, 0.3, 0.8], [0.9, 0.8, 0.3]])
    picture, others = colors[number[rows][:, rows]].movedim(-1, 0), []
    for hides in (hidden_seams, lambda exemplar: None):
        monkeypatch.setattr("synth.texture.sewing.hidden_seams", hides)
        apart = (tile(picture, band=12).image[None] - colors[:, :, None, None]).abs().amax(1).amin(0)
        others.append(float((apart > 0.02).float().mean()))
    assert others[0] < 0.02 < 0.5 * others[1]


@pytest.mark.parametrize(("axes", "side"), [("xy", (202, 203)), ("x", (200, 201)), ("y", (203, 200))])
def test_a_large_picture_is_sewn_where_it_is_coarser_and_then_as_there(
    axes: str, side: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its inside stays, nothing is left uncovered, and at its borders it is like itself; of an odd side, too."""
    whole = MADE["coins"](203, 20, 1)
    picture, numbers = whole.image[:, : side[0], : side[1]], whole.numbers[: side[0], : side[1]]
    apart = {}
    for pixels in (203**2, 203**2 // 2):
        monkeypatch.setattr("synth.texture.tiling.LAID_FINE", pixels)
        monkeypatch.setattr("kwatra.pieces.seams.gaps.LOOKED_AT", pixels)
        told = list[float]()
        made = tile(picture, axes=axes, band=24, report=lambda what, part, told=told: told.append(part))
        assert told == sorted(told)
        assert told[-1] == 1
        down, right = 24 * ("y" in axes), 24 * ("x" in axes)
        inside = (slice(None), slice(down, side[0] - down), slice(right, side[1] - right))
        assert torch.equal(made.image[inside], picture[inside])
        assert (made.take(picture) - made.image).abs().mean() < 0.02
        for axis, name in enumerate("yx"):
            if name in axes:
                assert wrapped_step(made.image.numpy(), axis + 1) < 1.6 * usual_step(picture.numpy(), axis + 1)
        row, column = np.asarray(made.source[-2:]).astype(int)
        apart[pixels] = cut_elements(numbers.numpy(), row * side[1] + column)["mixed"]
    assert max(apart.values()) < 0.2


def test_what_is_sewn_at_full_resolution_lies_where_it_does_at_half(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a picture twice as large, each pixel twice, nearly all comes from twice as far, but for a coarse pixel."""
    picture = MADE["coins"](96, 16, 2).image
    double = picture.repeat_interleave(2, 1).repeat_interleave(2, 2)
    monkeypatch.setattr("kwatra.pieces.seams.gaps.LOOKED_AT", 96**2)
    small, again = np.asarray(tile(picture, band=16).source[1:]).astype(int), {}
    for pixels in (96**2, 192**2):
        monkeypatch.setattr("synth.texture.tiling.LAID_FINE", pixels)
        large = np.asarray(tile(double, band=32).source[1:]).astype(int)
        again[pixels] = (np.abs(large[:, ::2, ::2] - 2 * small).max(0) <= 2).mean()
    assert again[96**2] > 0.85 > 0.7 > again[192**2]  # .91 and .62; .44 are inside and stay
