"""Which guides are of labels, and what shades ask for."""

import numpy as np
import pytest
import torch

from synth import InputError
from synth.texture import labels
from synth.texture.guidance import Guide
from synth.texture.labeling import Labels

WANTED = np.repeat(np.array([0, 0, 200, 90], np.uint8), 10)[None].repeat(20, 0)


def found(*maps: np.ndarray, wanted: np.ndarray = WANTED) -> Labels | None:
    images = [torch.zeros(1, *each.shape[:2]) for each in maps]
    return Labels.of(Guide.of(([*maps], wanted), 1.0, images))


def collage() -> np.ndarray:
    """0 on the left, 90 above 200 on the right, uint8 (24, 40)."""
    made = np.zeros((24, 40), np.uint8)
    made[:10, 16:], made[10:, 16:] = 90, 200
    return made


def test_rectangles_of_an_exemplar_are_textures() -> None:
    made = found(collage())
    assert made is not None
    left, upper, lower = (
        (0, (slice(*rows), slice(*columns)))
        for rows, columns in (((0, 24), (0, 16)), ((0, 10), (16, 40)), ((10, 24), (16, 40)))
    )
    assert made.textures == [[left], [upper], [lower]]
    np.testing.assert_array_equal(made.wanted, np.array([0, 0, 2, 1]).repeat(10)[None].repeat(20, 0))


def test_exemplars_of_one_label_are_one_texture_and_what_is_not_wanted_is_none() -> None:
    flat = [np.full((12, 14), value, np.uint8) for value in (200, 0, 200, 90)]
    made = found(*flat, wanted=np.where(WANTED == 90, 0, WANTED).astype(np.uint8))
    assert made is not None
    whole = slice(0, 12), slice(0, 14)
    assert made.textures == [[(1, whole)], [(0, whole), (2, whole)]]


def test_colors_are_labels_too() -> None:
    colors = np.stack([collage(), np.where(np.arange(24)[:, None] < 12, 0, 50) + 0 * collage()], -1).astype(np.uint8)
    lower = colors[20:, :20].repeat(3, 0)  # of the left, and of the right, both below
    made = found(colors, wanted=lower)
    assert made is None  # between rows 10 and 12 the right has a strip of a fourth color
    colors[10:12] = colors[12:14]
    made = found(colors, wanted=lower)
    assert made is not None
    rows = slice(10, 24)
    assert made.textures == [[(0, (rows, slice(0, 16)))], [(0, (rows, slice(16, 40)))]]
    np.testing.assert_array_equal(made.wanted, np.where(np.arange(20) < 16, 0, 1)[None].repeat(12, 0))


def test_borders_that_are_drawn_smoothly_are_of_the_nearest_label() -> None:
    smooth = WANTED.copy()
    smooth[:, 20] = 120  # between 0 and 200
    made = found(collage(), wanted=smooth)
    assert made is not None
    assert (made.wanted[:, 20] == 1).all()  # 90
    smooth[:, 10:20] = 120
    assert found(collage(), wanted=smooth) is None


@pytest.mark.parametrize(
    "form",
    [
        np.tri(24, 40, dtype=np.uint8) * 200,
        np.arange(40, dtype=np.uint8)[None].repeat(24, 0) * 5,
        np.random.default_rng(0).integers(0, 255, (24, 40), np.uint8),
        np.where(np.arange(40) < 7, 0, 200).astype(np.uint8)[None].repeat(24, 0),
    ],
    ids=["a triangle", "a ramp", "noise", "a strip"],
)
def test_other_forms_and_maps_that_vary_are_no_labels(form: np.ndarray) -> None:
    assert found(form, wanted=form) is None


def test_maps_of_videos_are_none() -> None:
    clip = np.zeros((4, 24, 40, 1), np.uint8)
    assert Labels.of(Guide.of((clip, clip), 1.0, [torch.zeros(1, 4, 24, 40)])) is None


def test_shades_stand_for_exemplars_from_dark_to_light() -> None:
    exemplars = [np.zeros((9, 12, 3)), np.zeros((11, 8, 3)), np.zeros((10, 10, 3))]
    drawn = np.stack([WANTED, WANTED, WANTED // 2], -1)
    drawn[:, 20] = 70
    maps, output = labels(exemplars, drawn)
    assert [(each.shape, set(each.ravel())) for each in maps] == [
        ((9, 12, 1), {0}),
        ((11, 8, 1), {1}),
        ((10, 10, 1), {2}),
    ]
    np.testing.assert_array_equal(output[:, 21:, 0], np.array([2] * 9 + [1] * 10)[None].repeat(20, 0))
    assert (output[:, 20] == 1).all()
    tensors, wanted = labels([torch.zeros(1, 9, 12), torch.zeros(1, 8, 8)], torch.from_numpy(WANTED == 0)[None].float())
    assert [tuple(each.shape) for each in tensors] == [(1, 9, 12), (1, 8, 8)]
    assert torch.equal(wanted[0] == 1, torch.from_numpy(WANTED == 0))


@pytest.mark.parametrize(
    ("drawn", "there"),
    [
        (WANTED, "3 shades for 2"),
        (WANTED * 0, "1 shade for 2 exemplars; draw a shade for each"),
        (np.arange(800).reshape(20, 40), "more than 64 shades"),
    ],
)
def test_another_number_of_shades_is_refused(drawn: np.ndarray, there: str) -> None:
    with pytest.raises(InputError, match=there):
        labels([np.zeros((9, 12)), np.zeros((9, 12))], drawn)
