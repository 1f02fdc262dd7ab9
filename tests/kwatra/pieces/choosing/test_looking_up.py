"""What is looked up place by place, against arrays indexed at once."""

import numpy as np
import pytest

from kwatra.base.spans import in_volume, volume
from kwatra.cut import FREE, KEEP, TAKE, VOID
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing.comparing import take_known
from kwatra.pieces.loops import quantile
from kwatra.pieces.seams.cost import SeamCost
from kwatra.pieces.seams.mosaic import Mosaic
from kwatra.pieces.sheet import Offer, Patch, Sheet, cheapest_cuts
from kwatra.pieces.sheet.pixels import count_most, look


def test_values_are_taken_where_they_are_known():
    rng = np.random.default_rng(0)
    image, places, known = rng.random((3, 50)), rng.integers(0, 50, (2, 40), np.int32), rng.random((2, 40)) < 0.6
    ones, against = np.full((2, 4, 40), np.nan), np.full((2, 3, 40), np.nan)
    take_known(image, np.array([0, 0, 1]), places, known, ones, against)
    for box in range(2):
        wanted = np.where(known[box], image[:, places[box]], 0)
        np.testing.assert_array_equal(ones[box], [*wanted, known[box]])
        np.testing.assert_allclose(against[box], [(wanted[:2] ** 2).sum(0), wanted[2] ** 2, known[box]])


@pytest.mark.parametrize("shapes", [[(7, 9)], [(4, 5, 6), (3, 6, 4)]])
def test_coordinates_are_those_that_places_are_made_of(shapes):
    rng = np.random.default_rng(0)
    mosaic = Mosaic([rng.random((2, *shape), np.float32) for shape in shapes])
    for number, shape in enumerate(shapes):
        lines = [np.arange(-1, n + 1) for n in shape]
        home, at = mosaic.coordinates(mosaic.places(number, lines))
        assert (home == number).all()
        np.testing.assert_array_equal(at, np.meshgrid(*lines, indexing="ij"))
        assert home.dtype == at.dtype == np.int32


@pytest.mark.parametrize("start", [(1, 2), (0, 0), (3, 2), (-2, 2), (2, 4), (-1, 5)])
def test_a_box_may_pass_the_border_where_the_sheet_wraps(start):
    mosaic = Mosaic([np.zeros((1, 4, 4), np.float32)])
    sheet = Sheet(mosaic, (6, 7), (True, True), SeamCost(mosaic))
    sheet.label = np.arange(42).reshape(6, 7)
    rows, columns = (np.arange(s, s + e) % n for s, e, n in zip(start, (3, 4), (6, 7), strict=True))
    np.testing.assert_array_equal(sheet.label[sheet.indices(Box(start, (3, 4)))], sheet.label[np.ix_(rows, columns)])
    sheet.places[:], sheet.label[::2] = np.arange(42).reshape(6, 7), -1
    places, known, starts = np.empty((2, 1, 3, 4), int), np.empty((2, 1, 3, 4), bool), in_volume([(1, 1), start], 0)
    label = volume(sheet.label, 2)
    look(label, volume(sheet.places[None], 2), starts, places, known)
    np.testing.assert_array_equal(places[1, 0], sheet.places[np.ix_(rows, columns)])
    np.testing.assert_array_equal(places[0, 0], sheet.places[1:4, 1:5])
    np.testing.assert_array_equal(known[1, 0], np.broadcast_to(rows[:, None] % 2 == 1, (3, 4)))
    sheet.label[1], sheet.label[3:] = [0, 3, 1, 3, 1, 3, 1], -1
    most, filled = np.empty(2, int), sheet.label[None, None, rows][..., columns] >= 0
    for patches, wanted in ((4, [np.bincount(sheet.label[1, 1:5]).argmax(), 0]), (0, [0, 0])):
        labels = sheet.label[np.ix_(rows, columns)]
        wanted[1] = np.bincount(labels[labels >= 0], minlength=1).argmax() if patches else 0
        count_most(label, starts, np.stack([sheet.label[None, 1:4, 1:5] >= 0, filled[0]]), patches, most)
        assert most.tolist() == wanted


@pytest.mark.parametrize("start", [(1, 2), (-2, 4), (3, -1)])
def test_a_window_shows_what_lies_in_a_box_and_around_it(start):
    rng, shape = np.random.default_rng(0), (7, 8)
    mosaic = Mosaic([rng.random((2, *shape), np.float32)])
    sheet = Sheet(mosaic, shape, (True, True), SeamCost(mosaic))
    for first in ((0, 0), (3, 3)):
        sheet.lay(Patch(0, first, Box(first, (4, 5))))
    sheet.fixed[:, 3:5] = True
    _, window = sheet.windows([Box((0, 0), (2, 3)), Box(start, (3, 4))])
    rows, columns = (np.arange(s - 1, s + e + 1) % n for s, e, n in zip(start, (3, 4), shape, strict=True))
    at = np.ix_(rows, columns)
    filled = sheet.label[at] >= 0
    np.testing.assert_array_equal(window.kept, np.where(filled, KEEP, VOID))
    np.testing.assert_array_equal(window.laid, np.where(sheet.fixed[at], KEEP, np.where(filled, FREE, TAKE)))
    np.testing.assert_array_equal(window.fixed, sheet.fixed[at])
    np.testing.assert_array_equal(window.places, sheet.places[at])
    seams = sheet.seams[0][at][:-1], sheet.seams[1][at][:, :-1]
    for found, wanted in zip(window.remembered, seams, strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert window.total == sum(int(cost.sum()) for cost in seams) > 0


def test_a_cut_changes_the_pixels_that_take_it_and_how_often_places_are_shown():
    rng, shape = np.random.default_rng(0), (7, 8)
    mosaic = Mosaic([rng.random((2, *shape), np.float32)])
    sheet, shown = Sheet(mosaic, shape, (True, True), SeamCost(mosaic)), np.zeros(mosaic.cell)
    for first in ((0, 0), (3, 3), (-2, 5), (1, -1)):
        before, patch = sheet.places.copy(), Patch(0, first, Box(first, (4, 5)))
        of_one = np.array([0, 1]), np.array([first]), np.zeros(1), np.ones(1)
        cuts = cheapest_cuts(sheet, Offer(sheet.windows([patch.box]), [patch.box], *of_one, np.inf))
        sheet.commit_each([cuts], [(0, 0)], shown)
        (cut,) = cuts
        at = np.ix_(
            *(np.arange(s, e) % n for s, e, n in zip(cut.window.box.start, cut.window.box.stop, shape, strict=True))
        )
        np.testing.assert_array_equal(sheet.places[at], np.where(cut.take, cut.places, before[at]))
        np.testing.assert_array_equal(sheet.label[at] == len(sheet.patches) - 1, cut.take)
        counts = np.bincount(sheet.places[sheet.filled], minlength=shown.size)
        np.testing.assert_array_equal(shown.ravel(), counts)


def test_a_quantile_is_numpys_bit_for_bit():
    values = np.random.default_rng(0).random(301)
    for numbers in (values, values.round(1), np.sort(values)[::-1].copy()):
        for count in (1, 2, 3, 40, 301):
            for share in (0.0, 0.05, 0.25, 0.6, 1.0):
                assert quantile(numbers[:count], share) == np.quantile(numbers[:count], share)
