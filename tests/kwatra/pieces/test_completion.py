"""Elements that a hole cuts are completed by others of the same form, whatever their color."""

from typing import Any

import numpy as np
import pytest
import torch
from discs import discs
from torch import Tensor

from kwatra import Exemplar
from kwatra.elements import Lattice
from kwatra.pieces import GivenCopies, Mosaic, SeamCost, Sheet, hidden_seams
from kwatra.pieces.completion import complete

HOLE = slice(48, 92), slice(50, 88)


def completed(
    image: Tensor, hole: tuple[slice, slice] = HOLE, *asked: Any
) -> tuple[np.ndarray, np.ndarray, Sheet[Mosaic]]:
    """What was laid, where what is shown comes from (2, H, W), and the sheet, of an image around its hole."""
    missing = torch.zeros(image.shape[1:], dtype=torch.bool)
    missing[hole] = True
    exemplar = Exemplar.of([torch.where(missing, 0.5, image)], masks=[~missing])
    source = torch.where(missing, -1, torch.from_numpy(np.indices(missing.shape)))
    mosaic = Mosaic([exemplar.canvas.numpy()])
    sheet = Sheet(mosaic, missing.shape, (False, False), SeamCost(mosaic))
    given = GivenCopies(missing.shape, source)
    given.lay(sheet)
    done = complete(sheet, given, exemplar, exemplar.canvas.numpy(), hidden_seams(exemplar), *asked)
    return done, mosaic.coordinates(sheet.places)[1], sheet


@pytest.mark.parametrize(("seed", "noise"), [(0, 0.0), (1, 0.03), (2, 0.03)])
def test_discs_that_a_hole_cuts_are_round(seed: int, noise: float) -> None:
    image, number = discs(6, 6, seed, noise)
    done, there, sheet = completed(image)
    shown = number[tuple(there)]
    hole = np.zeros(number.shape, bool)
    hole[HOLE] = True
    cut = set(np.unique(number[hole])) & set(np.unique(number[~hole])) - {0}
    assert len(cut) >= 4
    for one in cut:
        missing = (number == one) & hole
        assert (done & missing).sum() > 0.9 * missing.sum()
        assert (shown[done & missing] > 0).mean() > 0.9
    rest = done & ~np.isin(number, list(cut))
    assert (shown[rest] > 0).sum() < 0.05 * done.sum()
    assert not (done & ~hole).any()
    assert np.array_equal(sheet.filled, ~hole | done)
    assert sheet.fixed[done].all()
    assert not hole[tuple(there[:, done])].any()  # nothing is copied from the hole


def test_only_whole_elements_complete_others() -> None:
    image, number = discs(6, 6, 3)
    done, there, _ = completed(image)
    hole = np.zeros(number.shape, bool)
    hole[HOLE] = True
    cut = set(np.unique(number[hole]))
    used = set(np.unique(number[tuple(there[:, done])])) - {0}
    assert used
    assert not used & (cut - {0})


def test_nothing_is_completed_where_the_hole_cuts_nothing() -> None:
    image, number = discs(6, 6, 1)
    row, column = (np.argwhere(number == 15).mean(0)).round().astype(int)
    image[:, row - 12 : row + 13, column - 12 : column + 13] = 0.1
    done, _, sheet = completed(image, (slice(row - 2, row + 3), slice(column - 2, column + 3)))
    assert not done.any()
    assert np.count_nonzero(~sheet.filled) == 25


def test_elements_are_completed_on_the_grain_and_in_step() -> None:
    image, _ = discs(6, 6, 1)
    done, there, _ = completed(image, HOLE, (4, 2))
    offsets = np.indices(done.shape)[:, done] - there[:, done]
    assert done.any()
    assert not (offsets.T % (4, 2)).any()
    done, there, _ = completed(image, HOLE, (1, 1), Lattice(26.0 * torch.eye(2, dtype=torch.float64), 1.0))
    offsets = np.indices(done.shape)[:, done] - there[:, done]
    away = np.abs((offsets + 13) % 26 - 13).max(0)
    assert (away <= 1).mean() > 0.9


def test_what_has_another_form_than_all_others_is_not_completed() -> None:
    image, number = discs(6, 6, 2)
    row, column = number.shape[0] // 2, 52  # a square across the hole's left border, among discs
    image[:, row - 18 : row + 19, column - 20 : column + 18] = 0.1
    image[:, row - 13 : row + 14, column - 15 : column + 13] = 0.8
    done, _, _ = completed(image)
    assert done.any()
    assert done[row - 9 : row + 10, 51:54].mean() < 0.2


def test_places_are_counted() -> None:
    mosaic = Mosaic([np.random.default_rng(0).random((1, 4, 5)).astype(np.float32)])
    at = np.array([0, 3, 3, 2]), np.array([4, 1, 1, 0])
    counts = mosaic.counted(mosaic.places_of(at))
    assert counts.shape == mosaic.cell == (6, 7)
    assert counts[1:-1, 1:-1][at].tolist() == [1, 2, 2, 1]
    assert counts.sum() == 4
