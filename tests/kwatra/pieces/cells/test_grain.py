"""The grain of warped elements is read in blocks that are moved as a whole, within elements alone."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from made import MADE
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar
from kwatra.loop.beginning import begin
from kwatra.pieces import Cells, find_cells
from kwatra.pieces.cells.grain import BLOCK, NEAR, SOFT, grain_of


@pytest.fixture(scope="module")
def stones() -> Exemplar:
    return Exemplar.of(MADE["stones"](128, 32, 0).image)


@pytest.fixture(scope="module")
def cells(stones: Exemplar) -> Cells:
    found = find_cells(stones)
    assert found is not None
    return found


def test_blocks_are_moved_as_far_as_their_pixels_are_on_the_mean(cells: Cells) -> None:
    row, column = np.indices((100, 90)).astype(float)
    places = np.stack([20 + row / 1.5, 10 + column])
    copy, warped = np.where(column < 45, 0, 1), column > 3
    grain = grain_of(places, copy, warped, cells)
    own = np.rint(places).astype(int)
    within = ndimage.distance_transform_edt(cells.element)
    assert np.array_equal(grain.places[:, ~warped], own[:, ~warped])
    assert not grain.share[~warped].any()
    for top, left in ((8, 16), (40, 40), (64, 80)):
        for number in (0, 1):
            block = np.zeros(copy.shape, bool)
            block[top : top + BLOCK, left : left + BLOCK] = True
            block &= copy == number
            if not block.any():
                continue
            moved = np.rint((places - np.indices(copy.shape))[:, block].mean(1))[:, None]
            there = np.argwhere(block).T + moved.astype(int)
            apart = grain.share[block] > 0
            assert np.array_equal(grain.places[:, block][:, apart], there[:, apart])
            least = np.minimum(within[tuple(own[:, block])], within[tuple(there)])
            one = cells.number[tuple(own[:, block])] == cells.number[tuple(there)]
            np.testing.assert_allclose(grain.share[block], np.clip((least - NEAR) / SOFT, 0, 1) * one, atol=1e-6)
    assert (grain.share == 1).mean() > 0.3


def test_what_is_not_warped_keeps_its_detail(cells: Cells) -> None:
    places = np.indices((60, 60)) + np.array([7, 11])[:, None, None]
    grain = grain_of(places.astype(float), np.zeros((60, 60), int), np.ones((60, 60), bool), cells)
    assert np.array_equal(grain.places, places)


def test_places_beyond_the_exemplar_are_on_its_border(cells: Cells) -> None:
    row, column = np.indices((60, 60)).astype(float)
    places = np.stack([np.minimum(100 + row / 2, 127.0), column])
    grain = grain_of(places, np.zeros((60, 60), int), np.ones((60, 60), bool), cells)
    assert grain.places.max() <= 127


def test_stones_that_are_drawn_out_keep_their_grain() -> None:
    exemplar = Exemplar.of(MADE["granite"](128, 32, 5).image)
    begun = begin(exemplar, (160, 160))
    fitted = begun.fitted
    assert fitted is not None
    warped = (fitted.places != fitted.places.round()).any(0) & (fitted.share == 1)
    assert float(warped.float().mean()) > 0.1
    blurred = replace(begun, fitted=fitted._replace(share=torch.zeros_like(fitted.share)))
    drawn, drawn_out = (detail(start.copied()[0])[warped.numpy()].std() for start in (begun, blurred))
    within = ndimage.distance_transform_edt(find_cells(exemplar).element) > 3
    own = detail(exemplar.canvas)[within].std()
    assert drawn > 0.93 * own > 1.03 * drawn_out


def detail(image: Tensor) -> np.ndarray:
    """How bright pixels (H, W) are, against what is around them."""
    gray = image.mean(0).numpy()
    return gray - ndimage.gaussian_filter(gray, 1.5)
