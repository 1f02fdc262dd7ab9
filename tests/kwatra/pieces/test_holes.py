"""Blocks that lie on an exemplar's holes, where they show nothing."""

import numpy as np
import pytest
import torch
from compared import mismatch

from kwatra import Exemplar
from kwatra.pieces.blocks import BlockStart
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing.agreement import DIGITS, FAIR, Agreement
from kwatra.pieces.choosing.corners import ENOUGH, SEEN, SHOWN, Corners
from kwatra.pieces.seams.cost import SeamCost
from kwatra.pieces.seams.mosaic import Mosaic, by_place
from kwatra.pieces.sheet import Offer, Patch, Sheet, cheapest_cuts

SHAPE, BLOCK = (48, 56), (20, 24)
RNG = np.random.default_rng(0)
IMAGE = torch.from_numpy(RNG.random((2, *SHAPE), np.float32))


def with_holes(kind="one"):
    """Where an exemplar of SHAPE has some holes: one within, scattered pixels, or nearly everywhere."""
    holes = np.zeros(SHAPE, bool)
    if kind == "one":
        holes[18:30, 20:36] = True
    elif kind == "specks":
        holes = np.random.default_rng(1).random(SHAPE) < 0.2
    else:
        holes[:, 3:] = True
    return holes


def corners(holes, grain=(1, 1), hang=(0, 0)):
    exemplar = Exemplar.of([IMAGE], masks=[torch.from_numpy(~holes)])
    return Corners.on_holes(exemplar, BLOCK, grain).hanging(hang)


def hidden_by_hand(found, holes, values):
    """The sum of a box's values (*E) over what a block does not show, for each block."""
    wide = np.pad(holes, [(h, h) for h in found.hang], constant_values=True)
    first = found.at(np.arange(found.valid.size)) + np.array(found.hang)
    sums = [
        (values * wide[tuple(slice(a, a + n) for a, n in zip(at, values.shape, strict=True))]).sum() for at in first
    ]
    return np.reshape(sums, found.valid.shape)


@pytest.mark.parametrize("kind", ["one", "specks"])
@pytest.mark.parametrize(("grain", "hang"), [((1, 1), (0, 0)), ((2, 4), (2, 4))])
def test_blocks_are_as_large_as_without_holes_and_show_half_of_themselves_at_least(kind, grain, hang):
    holes = with_holes(kind)
    found = corners(holes, grain, hang)
    assert found.block == BLOCK
    shown = np.prod(BLOCK) - hidden_by_hand(found, holes, np.ones(BLOCK))
    np.testing.assert_array_equal(found.pixels, shown)
    np.testing.assert_array_equal(found.valid, shown >= SHOWN * np.prod(BLOCK))
    np.testing.assert_array_equal(found.owned, by_place(~holes))


def test_blocks_are_smaller_where_parts_of_them_could_hardly_show_anything():
    holes = np.zeros(SHAPE, bool)
    holes[6:42, 8:48] = True  # whatever the block, its middle lies in there
    assert Corners.on_holes(Exemplar.of([IMAGE], masks=[torch.from_numpy(~holes)]), BLOCK, (1, 1)).holes is None
    holes = with_holes()
    starts = corners(holes).valid
    seen = sum((~holes)[y : y + BLOCK[0], x : x + BLOCK[1]] for y, x in np.argwhere(starts))
    assert seen.min() >= SEEN * starts.size
    assert corners(with_holes("most")).holes is None


def test_whole_blocks_are_laid_where_they_are_asked_for_and_not_much_smaller():
    for kind, between in (("one", True), ("specks", False)):
        exemplar = Exemplar.of([IMAGE], masks=[torch.from_numpy(~with_holes(kind))])
        fitted, found = Corners.fitting(exemplar, BLOCK, (1, 1)), Corners.on_holes(exemplar, BLOCK, (1, 1), whole=True)
        assert (min(fitted.block) >= min(BLOCK) / 2) == between
        assert found.block == (fitted.block if between else BLOCK)
        assert (found.holes is None) == between


def test_an_exemplar_without_holes_has_the_blocks_that_fit():
    found = corners(np.zeros(SHAPE, bool))
    assert found.holes is None
    assert found.block == BLOCK
    assert not len(found.owned)


@pytest.mark.parametrize("hang", [(0, 0), (3, 5)])
def test_blocks_cover_what_is_missing_as_well_as_a_part_of_them_can(hang):
    holes, rng = with_holes(), np.random.default_rng(2)
    found = corners(holes, (1, 1), hang)
    known = np.zeros((3, *BLOCK), bool)
    known[0, :, :10] = known[1] = True
    known[1, 4:7, 5] = known[2, rng.random(BLOCK) < 0.4] = False
    covering = found.emptying_least(~known)
    for box in range(3):
        empty = hidden_by_hand(found, holes, ~known[box])
        assert (
            covering[box].sum() >= ENOUGH * found.valid.sum() or empty[covering[box]].max() == (~known[box]).sum() - 1
        )
        assert not (covering[box] & ~found.valid).any()
        if (found.valid & ~covering[box]).any():
            assert empty[covering[box]].max() < empty[found.valid & ~covering[box]].min()
        assert empty[covering[box]].max() < (~known[box]).sum()
    assert found.emptying_least(known & ~known)[1].sum() == found.valid.sum()  # nothing is missing


@pytest.mark.parametrize("hang", [(0, 0), (2, 3)])
def test_what_a_block_does_not_show_agrees_as_a_fair_one_does(hang):
    holes, rng = with_holes(), np.random.default_rng(3)
    found = corners(holes, (1, 1), hang)
    image = IMAGE.double().numpy() - 0.5
    agreement = Agreement([(image, 0.1)], found)
    places, known = rng.integers(0, 18, (2, 1, *BLOCK)), rng.random((1, *BLOCK)) < 0.6
    it = mismatch(agreement, Mosaic([image]).places_of(list(places)), known, found.valid[None])[0, 0]
    there = image[:, places[0, 0], places[1, 0]]
    wide = np.pad(image, [(0, 0), *[(h, h) for h in hang]])
    gone = np.pad(holes, [(h, h) for h in hang], constant_values=True)
    squares, seen = np.zeros(found.valid.shape), np.zeros(found.valid.shape)
    for y, x in np.ndindex(*found.valid.shape):
        part = slice(y, y + BLOCK[0]), slice(x, x + BLOCK[1])
        compared = known[0] & ~gone[part]
        squares[y, x] = ((wide[:, *part] - there) ** 2)[:, compared].sum()
        seen[y, x] = compared.sum()
    fair = np.quantile((squares / np.maximum(seen, 1))[found.valid], FAIR)
    expected = (squares + (known.sum() - seen) * fair) / (known.sum() * 0.1)
    np.testing.assert_allclose(it[found.valid], expected[found.valid], atol=10**-DIGITS + 1e-4)


@pytest.mark.parametrize("large", [False, True])
def test_where_a_patch_lies_on_holes_nothing_changes(large, monkeypatch):
    if large:
        monkeypatch.setattr("kwatra.pieces.sheet.cheapest.solved_at_once", lambda laid: False)
    owned = np.random.default_rng(4).random((12, 12)) < 0.7
    mosaic = Mosaic([RNG.random((1, 12, 12), np.float32)])
    sheet = Sheet(mosaic, (12, 16), (False, False), SeamCost(mosaic))
    sheet.lay(Patch(0, (0, 0), Box((0, 0), (12, 9))))
    box = Box((0, 4), (12, 12))
    of_one = np.array([0, 1]), np.array([[0, 4]]), np.zeros(1), np.ones(1)
    (cut,) = cheapest_cuts(sheet, Offer(sheet.windows([box]), [box], *of_one, np.inf), by_place(owned))
    taken = np.zeros((12, 16), bool)
    taken[sheet.indices(cut.window.box)] = cut.take
    before = sheet.label.copy()
    assert not taken[:, 4:][~owned].any()
    assert taken[:, 9:][owned[:, 5:]].all()  # what is empty is filled with what is owned
    sheet.commit(cut)
    np.testing.assert_array_equal(sheet.label[~taken], before[~taken])


@pytest.mark.parametrize("wraps", [False, True])
@pytest.mark.parametrize("kind", ["one", "specks"])
def test_all_is_filled_with_what_is_no_hole(kind, wraps):
    holes = with_holes(kind)
    exemplar = Exemplar.of([IMAGE], masks=[torch.from_numpy(~holes)])
    start = BlockStart(
        exemplar, (70, 60), BLOCK, (2, 2), torch.Generator().manual_seed(0), wraps=(wraps, wraps), usage=0.5, seams=3
    )
    assert start.layer.corners.block == BLOCK
    where = start.run().numpy()
    assert start.sheet.filled.all()
    assert not holes[tuple(where)].any()
    assert start.layer.used.sum() == 70 * 60
    part = start.anew(Box((10, 20), (30, 30)), torch.Generator().manual_seed(1))
    assert part.sheet.filled.all()
    assert not holes[tuple(part.where.numpy())].any()
