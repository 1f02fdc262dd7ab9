import numpy as np
import pytest
import torch

from kwatra import Exemplar
from kwatra.base import generator_of
from kwatra.pieces import BlockStart, Box


@pytest.mark.parametrize("wraps", [(False, False), (True, True)])
def test_a_part_is_laid_anew_as_the_start_was_laid(wraps, recomputed_seams):
    image = torch.rand(1, 32, 32, generator=generator_of(0))
    start = BlockStart(
        Exemplar.of(image), (50, 60), (12, 12), (1, 1), generator_of(0), usage=0.35, seams=2, wraps=wraps
    )
    where = start.run()
    box = Box((40, 50), (18, 18)) if wraps[0] else Box((20, 30), (15, 20))
    other = start.anew(box, generator_of(1))
    assert torch.equal(start.where, where)
    assert other.sheet.filled.all()
    assert not torch.equal(
        other.where[(slice(None), *start.sheet.indices(box))], where[(slice(None), *start.sheet.indices(box))]
    )
    count = torch.zeros(32, 32).index_put(tuple(other.where), torch.ones(()), accumulate=True)
    np.testing.assert_array_equal(other.layer.used, count.numpy())
    np.testing.assert_array_equal(other.sheet.seams, recomputed_seams(other.sheet))


def test_a_sheet_is_cleared_of_what_lies_in_a_box_and_of_the_seams_around_it(recomputed_seams):
    image = torch.rand(1, 32, 32, generator=generator_of(0))
    start = BlockStart(Exemplar.of(image), (50, 60), (12, 12), (1, 1), generator_of(0), usage=0.35, seams=2)
    start.run()
    sheet = start.sheet.copy()
    before = sheet.seams.copy()
    sheet.clear(Box((10, 20), (15, 9)))
    empty = np.zeros((50, 60), bool)
    empty[10:25, 20:29] = True
    np.testing.assert_array_equal(sheet.filled, ~empty)
    np.testing.assert_array_equal(sheet.seams, recomputed_seams(sheet))
    assert sheet.total == sheet.seams.sum() < before.sum()
    np.testing.assert_array_equal(start.sheet.seams, before)
    assert start.sheet.filled.all()


def test_what_is_to_be_kept_stays_when_a_box_is_cleared(recomputed_seams):
    image = torch.rand(1, 32, 32, generator=generator_of(0))
    start = BlockStart(Exemplar.of(image), (50, 60), (12, 12), (1, 1), generator_of(0), usage=0.35, seams=2)
    start.run()
    keep = np.zeros((50, 60), bool)
    keep[:, 25:] = True
    sheet = start.sheet.copy()
    sheet.clear(Box((10, 20), (15, 9)), keep)
    empty = np.zeros((50, 60), bool)
    empty[10:25, 20:25] = True
    np.testing.assert_array_equal(sheet.filled, ~empty)
    np.testing.assert_array_equal(sheet.seams, recomputed_seams(sheet))
