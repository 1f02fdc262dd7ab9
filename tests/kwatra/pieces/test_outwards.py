"""Laying outwards from the middle of a large still: on both sides at once, as if on one after the other."""

import numpy as np
import pytest
import torch

from kwatra import Exemplar
from kwatra.base import generator_of
from kwatra.pieces import BlockStart, Box, Mosaic, Patch, SeamCost, Sheet, layer


@pytest.mark.parametrize("axis", [0, 1])
def test_what_is_laid_aside_is_taken_over_as_if_laid_in_turn(axis, recomputed_seams) -> None:
    rng = np.random.default_rng(axis)
    sources = Mosaic([rng.random((2, 9, 9))])

    def box(at: int, length: int = 5) -> Box:
        return Box((at, 1), (length, 5)) if axis == 0 else Box((1, at), (5, length))

    def lay(sheet: Sheet, *at: int) -> None:
        for start in at:
            shift = tuple(rng.integers(-3, 0, 2) + box(start).start)
            sheet.lay(Patch(0, shift, box(start)))

    sheet = Sheet(sources, (30, 8) if axis == 0 else (8, 30), (False, False), SeamCost(sources))
    lay(sheet, 10, 14)
    turns, rng_state = sheet.copy(), rng.bit_generator.state
    before, behind = sheet.aside(), sheet.aside()
    lay(behind, 18, 21, 25)
    later = rng.bit_generator.state
    lay(before, 7, 3)
    sheet.join(before, behind, axis, 18)
    rng.bit_generator.state = later
    lay(turns, 7, 3)
    rng.bit_generator.state = rng_state
    lay(turns, 18, 21, 25)
    for one, other in ((sheet.label, turns.label), (sheet.places, turns.places), (sheet.seams, turns.seams)):
        np.testing.assert_array_equal(one, other)
    assert (sheet.patches, sheet.total) == (turns.patches, turns.total)
    assert len(sheet.patches) == 7
    np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)


@pytest.mark.parametrize("wraps", [(False, False), (False, True), (True, False)])
def test_a_large_still_is_laid_outwards_the_same_by_any_number_of_threads(wraps, monkeypatch, recomputed_seams):
    asides, beside = [], layer.Layer._aside
    monkeypatch.setattr(layer.Layer, "_aside", lambda self, **how: asides.append(how) or beside(self, **how))
    image = torch.rand(3, 24, 26, generator=generator_of(1))
    laid = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        start = BlockStart(
            Exemplar.of(image), (100, 110), (12, 12), (1, 1), generator_of(0), seams=3, usage=0.5, wraps=wraps
        )
        laid.append((start, start.run()))
    assert asides == 3 * [how for axis in (1, 0) if not wraps[axis] for how in ({"backwards": (axis,)}, {})]
    start, where = laid[0]
    assert all(torch.equal(where, other) for _, other in laid)
    sheet = start.sheet
    assert sheet.filled.all()
    np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)
    np.testing.assert_array_equal(start.layer.shown, sheet.sources.counted(sheet.places.ravel()))
    shift = np.array([patch.shift for patch in sheet.patches])[sheet.label]  # each pixel is where its patch has it
    place = np.stack(np.indices(sheet.shape), -1) - where.permute(1, 2, 0).numpy()
    assert (((place - shift) % np.where(wraps, (100, 110), 10**6)) == 0).all()
