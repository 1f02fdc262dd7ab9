"""The elements of an exemplar one by one."""

import numpy as np
from discs import RADIUS, discs
from scipy import ndimage

from kwatra import Exemplar
from kwatra.pieces import Hidden, Parts, hidden_seams, parts_of


def test_discs_are_parts_one_by_one_though_they_touch() -> None:
    image, number = discs(6, 5)
    hidden = hidden_seams(Exemplar.of(image))
    parts = parts_of(hidden, np.ones(number.shape, bool))
    pairs = np.unique(np.stack([number[number > 0], parts.number[number > 0]]), axis=1)
    assert pairs.shape[1] == len(np.unique(pairs[1])) == 30  # each disc is one part, and each part one disc
    assert ndimage.label(hidden.depth > 0)[1] < 30  # shades at their rims join some
    ground = hidden.depth == 0
    assert not parts.number[ground].any()
    assert np.array_equal(parts.core, ndimage.distance_transform_edt(~ground) > 1)
    assert np.allclose(parts.deep, hidden.depth)
    assert parts.size == hidden.size


def test_what_is_nowhere_more_than_a_pixel_thick_is_a_part_of_its_own() -> None:
    depth = np.zeros((40, 40), np.float32)
    depth[4:20, 4:20] = 1.0
    depth[3, 4:20] = depth[20, 4:20] = 0.2
    depth[30, 5:15] = 0.2
    parts = parts_of(Hidden(depth, 1.0, 20.0, 0.5, 1.0), np.ones(depth.shape, bool))
    assert parts.core[30, 5:15].all()
    assert parts.core[4:20, 4:20].all()
    assert not parts.core[3].any()
    assert {*np.unique(parts.number)} == {0, 1, 2}
    assert (parts.number[3, 4:20] == parts.number[10, 10]).all()
    assert parts.number[30, 7] != parts.number[10, 10]


def test_those_are_whole_that_no_border_and_no_hole_cuts() -> None:
    image, number = discs(6, 5)
    image, number, inside = image[:, 14:], number[14:], np.ones((142, 130), bool)
    row, column = np.argwhere(number == 8)[0]
    inside[row : row + RADIUS, column - 3 : column + 3] = False
    parts = parts_of(hidden_seams(Exemplar.of(image)), inside)
    whole = parts.whole(inside)
    assert not whole[0]
    assert (parts.number[~inside] == -1).all()
    kept = {int(number[parts.number == one].max()) for one in np.flatnonzero(whole)}
    cut = {*range(1, 6), 8}
    beside = {*number[-8:].flat, *number[:, :8].flat, *number[:, -8:].flat}  # their rims may reach the border
    assert not kept & cut
    assert {*range(1, 31)} - cut - beside <= kept


def test_the_nearest_part_is_found_from_everywhere() -> None:
    number = np.where(np.random.default_rng(0).random((14, 17)) < 0.05, np.arange(14 * 17).reshape(14, 17), 0)
    number[3, 4] = -1  # nobody's
    parts = Parts(number, number > 0, np.zeros(number.shape), 3.0)
    places, here = np.argwhere(number > 0), np.indices(number.shape)[:, None]
    away = np.hypot(*(here - places.T[:, :, None, None]))
    nearest = parts.nearest
    for row, column in np.argwhere(number <= 0):
        best = away[:, row, column].min()
        assert nearest[row, column] in number[tuple(places[away[:, row, column] == best].T)]
    assert np.array_equal(nearest[number > 0], number[number > 0])
