"""Holes in cloth: its lines go on through them."""

import numpy as np
import pytest
import torch

from kwatra import Exemplar
from synth import fill
from synth.texture.cloth import NEAR, _move, filled_by_lines

SETT = np.repeat(np.arange(6), (10, 4, 12, 3, 6, 13))
TONES = np.random.default_rng(0).random((6, 3))


def tartan(height: int = 90, width: int = 100, grain: float = 0.0) -> np.ndarray:
    """A tartan (H, W, 3) of 48 px; grain: standard deviation of noise."""
    down, across = (TONES[SETT[np.arange(size) % 48]] for size in (height, width))
    noise = np.random.default_rng(1).standard_normal((height, width, 1))
    return 0.1 + 0.4 * (down[:, None] + across[None]) + grain * noise


def hole_in(shape: tuple[int, ...], *boxes: tuple[slice, slice]) -> np.ndarray:
    hole = np.zeros(shape, bool)
    for box in boxes:
        hole[box] = True
    return hole


@pytest.mark.parametrize(
    "boxes",
    [
        [(slice(30, 60), slice(20, 50))],
        [(slice(5, 75), slice(60, 75))],
        [(slice(70, 90), slice(0, 60))],
        [(slice(0, 9), slice(90, 100)), (slice(40, 47), slice(3, 80)), (slice(60, 80), slice(60, 80))],
    ],
)
def test_lines_are_restored(boxes: list[tuple[slice, slice]]) -> None:
    cloth, hole = tartan(), hole_in((90, 100), *boxes)
    made = fill(np.where(hole[..., None], 0.0, cloth), hole)
    assert np.abs(made.image - cloth).max() < 1e-3
    assert np.array_equal(made.image[~hole], cloth[~hole])
    rows, columns = made.source[1:]
    assert not hole[rows, columns].any()
    assert np.array_equal(rows[~hole], np.indices(hole.shape)[0][~hole])


def test_around_a_picture_lines_go_on_as_in_a_larger_one() -> None:
    truth, hole = tartan(220, 240), np.ones((220, 240), bool)
    hole[48:148, 96:206] = False
    made = fill(np.where(hole[..., None], 0.0, truth), hole)
    assert np.abs(made.image - truth).max() < 1e-6
    assert not hole[tuple(made.source[1:])].any()
    hole[100:110, 120:130] = True  # and of a picture that has a hole itself they do not
    picture = torch.from_numpy(truth).movedim(2, 0).float()
    known = torch.from_numpy(~hole)
    assert filled_by_lines(picture, ~known, Exemplar.of(picture, masks=[known]), None) is None


def test_many_specks_are_filled_from_about_them() -> None:
    cloth, hole = tartan(300, 320), hole_in((300, 320))
    hole[np.random.default_rng(3).integers(1, 299, 60), np.random.default_rng(4).integers(1, 319, 60)] = True
    made = fill(np.where(hole[..., None], 0.0, cloth), hole)
    assert np.abs(made.image - cloth).max() < 1e-3
    moved = np.abs(made.source[1:] - np.indices(hole.shape))[:, hole]
    assert 0 < moved.max() <= NEAR


def test_threads_come_from_elsewhere_and_lines_from_beside_the_hole() -> None:
    cloth, hole = tartan(grain=0.03), hole_in((90, 100), (slice(30, 60), slice(20, 50)))
    made = fill(np.where(hole[..., None], 0.0, cloth), hole).image
    apart = (made - tartan())[hole]
    assert apart.std() == pytest.approx(0.03, rel=0.1)  # grain, as everywhere
    smooth = (made - tartan())[30:60, 20:50].mean(1)
    assert np.abs(smooth).max() < 0.03  # of 30 pixels each


def test_eight_bits_of_gray_are_filled_too() -> None:
    cloth, hole = np.rint(255 * tartan()[..., 0]).astype(np.uint8), hole_in((90, 100), (slice(30, 60), slice(20, 50)))
    made = fill(np.where(hole, 0, cloth), hole).image
    assert made.dtype == np.uint8
    assert np.abs(made.astype(int) - cloth).max() <= 1


@pytest.mark.parametrize("name", ["noise", "a line without an end", "too large a hole"])
def test_what_lines_do_not_fill(name: str) -> None:
    picture = torch.from_numpy(tartan()).movedim(2, 0).float()
    boxes = {"noise": (slice(30, 60), slice(20, 50)), "a line without an end": (slice(30, 40), slice(0, 100))}
    hole = torch.from_numpy(hole_in((90, 100), boxes.get(name, (slice(10, 80), slice(10, 80)))))
    if name == "noise":
        picture = torch.rand(3, 90, 100, generator=torch.Generator().manual_seed(0))
    assert filled_by_lines(picture, hole, Exemplar.of(picture, masks=[~hole]), None) is None


def test_the_move_is_the_one_after_which_lines_differ_least() -> None:
    generator = torch.Generator().manual_seed(2)
    rows, columns = (torch.rand(2, size, generator=generator, dtype=torch.float64) for size in (14, 16))
    hole = torch.zeros(14, 16, dtype=torch.bool)
    hole[5:8, 6:8], hole[7, 9] = True, True
    hole[7, 8] = True
    missing = hole.clone()
    missing[1, 2] = True
    costs = {}
    for down in range(-13, 14):
        for right in range(-15, 16):
            there = hole.nonzero() + torch.tensor([down, right])
            if not bool(((there >= 0) & (there < torch.tensor([14, 16]))).all()) or bool(missing[tuple(there.T)].any()):
                continue
            apart = rows[:, hole.nonzero()[:, 0]] - rows[:, there[:, 0]]
            across = columns[:, hole.nonzero()[:, 1]] - columns[:, there[:, 1]]
            costs[down, right] = float(apart.square().sum() + across.square().sum())
    assert _move(hole, missing, rows, columns) == min(costs, key=costs.__getitem__)
