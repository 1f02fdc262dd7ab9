"""Whole elements in place of those that the exemplar's border cuts."""

import numpy as np
import pytest
import torch
from discs import RADIUS, discs
from scipy import ndimage

from kwatra import Exemplar
from kwatra.pieces.cells import Cells, find_cells, fitted
from kwatra.pieces.cells.standins import MOST, stand_ins

CUT_OFF = 7
"""Rows that are missing of the first row of discs: about a third of each."""


def cut_discs() -> tuple[Exemplar, np.ndarray, Cells]:
    """Discs of which the first row is cut off, the number of each pixel's on the canvas, and their cells."""
    image, number = discs(5, 6, seed=1)
    exemplar = Exemplar.of(image[:, 4 + CUT_OFF :].contiguous())
    cells = find_cells(exemplar)
    assert cells is not None
    return exemplar, number[4 + CUT_OFF :], cells


def middles(number: np.ndarray) -> np.ndarray:
    """Where the middles of discs are, of those that are cut as well, by number."""
    found = np.zeros((number.max() + 1, 2))
    for disc, box in enumerate(ndimage.find_objects(number), 1):
        found[disc] = box[0].stop - 1 - RADIUS, box[1].start + RADIUS
    return found


def test_a_whole_disc_stands_in_for_one_that_is_cut_and_lies_where_that_one_does() -> None:
    exemplar, number, cells = cut_discs()
    assert exemplar.canvas.shape[1:] == number.shape
    disc = np.zeros(len(cells.area), int)  # of each cell
    disc[cells.number[number > 0]] = number[number > 0]
    replaced = np.flatnonzero(cells.instead != np.arange(len(cells.area)))
    assert set(disc[replaced]) >= set(range(1, 7))
    assert cells.whole[cells.instead[replaced]].all()
    at = middles(number)
    for cell in replaced:
        moved = at[disc[cells.instead[cell]]] - at[disc[cell]]
        assert np.array_equal(cells.further[cell], moved)
    assert (cells.further[cells.instead == np.arange(len(cells.area))] == 0).all()


def test_colors_decide_among_whole_ones_of_one_form_and_form_whether_any_stands_in() -> None:
    number = np.zeros((60, 60), int)
    for one, (row, column) in enumerate([(-7, 5), (22, 5), (22, 25), (22, 45)], 1):
        number[max(row, 0) : row + 14, column : column + 10] = one
    colors = np.zeros((1, 60, 60), np.float32)
    for one, color in enumerate([0.6, 0.9, 0.2, 0.65], 1):
        colors[:, number == one] = color
    near = ndimage.distance_transform_edt(number == 0, return_distances=False, return_indices=True)
    cut, whole = np.arange(5) == 1, np.arange(5) > 1
    instead, further = stand_ins(number[tuple(near)], number > 0, colors, cut, whole)
    assert instead.tolist() == [0, 4, 2, 3, 4]
    assert further[1].tolist() == [29, 40]
    instead, _ = stand_ins(number[tuple(near)], number > 0, np.ones_like(colors), cut, whole)
    assert instead[1] in (2, 3, 4)
    rounder = number.copy()
    for one in (2, 3, 4):
        box = ndimage.find_objects(number)[one - 1]
        y, x = np.mgrid[-6.5:7, -4.5:5]
        rounder[box][(y / 7) ** 2 + (x / 5) ** 2 > 1] = 0
    instead, further = stand_ins(number[tuple(near)], rounder > 0, colors, cut, whole)
    assert instead.tolist() == [0, 1, 2, 3, 4]
    assert (further == 0).all()
    nobody = np.zeros(5, bool)
    assert stand_ins(number[tuple(near)], number > 0, colors, nobody, whole)[0].tolist() == [0, 1, 2, 3, 4]
    assert stand_ins(number[tuple(near)], number > 0, colors, cut, nobody)[0].tolist() == [0, 1, 2, 3, 4]


def test_of_many_whole_ones_some_are_looked_at() -> None:
    number = np.kron(np.arange(1, 401).reshape(20, 20), np.ones((8, 8), int))
    element = (np.indices(number.shape) % 8 < 6).all(0)
    cut, colors = np.arange(401) == 1, np.ones((1, *number.shape), np.float32)
    colors[:, number == 1] = colors[:, number == 22] = 0.5  # which would be the best
    step = -(-380 // MOST)
    assert step > 1
    instead, further = stand_ins(number, element, colors, cut, np.arange(401) > 20)
    assert (instead[1] - 21) % step == 0
    assert np.array_equal(further[1], np.argwhere(number == instead[1])[0])
    assert stand_ins(number, element, colors, cut, (np.arange(401) > 20) & (np.arange(401) < 30))[0][1] == 22


@pytest.mark.parametrize("inner", [False, True])
def test_what_is_cut_is_whole_in_an_output_unless_the_outputs_border_cuts_it(inner: bool) -> None:
    exemplar, number, cells = cut_discs()
    rows, columns = torch.meshgrid(torch.arange(80), torch.arange(100), indexing="ij")
    where = torch.stack([rows, columns])
    if inner:  # what is on the exemplar's border lies in the middle, below ground that goes on
        where = torch.stack([torch.where(rows < 40, rows + 40, rows - 40), columns])
    made = fitted(where, cells, exemplar.canvas.numpy()).places.round().long()
    if not inner:
        assert torch.equal(made[:, :12], where[:, :12])
        return
    assert exemplar.owner[tuple(made)].min() == 0
    shown, count = ndimage.label(number[tuple(made.numpy())] > 0)
    full = np.pi * RADIUS**2
    for box, area in zip(ndimage.find_objects(shown), np.bincount(shown.ravel())[1:], strict=True):
        inside = box[0].start > 0 and box[0].stop < 80 and box[1].start > 0 and box[1].stop < 100
        if inside:
            assert 0.75 * full < area < 1.12 * full  # some are squeezed
            assert abs((box[0].stop - box[0].start) - (box[1].stop - box[1].start)) <= 3
    assert count > 12


def test_loose_elements_that_come_too_near_move_apart_and_stay_round() -> None:
    image, number = discs(3, 5, seed=2)
    cells = find_cells(Exemplar.of(image))
    assert cells is not None
    assert cells.loose
    rows, columns = torch.meshgrid(torch.arange(78), torch.arange(130), indexing="ij")
    where = torch.stack([rows, torch.where(columns < 52, columns, columns - 15)])  # discs overlap by some 3 px
    made = fitted(where, cells, image.numpy()).places.round().long()
    shown, _ = ndimage.label(number[tuple(made.numpy())] > 0)
    full = int((number == 7).sum())
    for box, area in zip(ndimage.find_objects(shown), np.bincount(shown.ravel())[1:], strict=True):
        if box[1].start > 0 and box[1].stop < 130:
            assert 0.89 * full < area < 1.08 * full
            assert abs((box[0].stop - box[0].start) - (box[1].stop - box[1].start)) <= 2
    assert torch.equal(made[:, :, :20], where[:, :, :20])
