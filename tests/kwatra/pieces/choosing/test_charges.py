import numpy as np
import pytest
import torch
from compared import shown_near

from kwatra import Exemplar
from kwatra.elements import Lattice, Rows
from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.choosing.charges import (
    AROUND,
    EVEN,
    KINDS,
    LIKE,
    STEP,
    SceneUse,
    StepCosts,
    charged,
)
from kwatra.pieces.choosing.corners import Corners

GRID = Lattice(torch.tensor([[0.0, 8.0], [6.0, 0.0]], dtype=torch.float64), 0.5)


@pytest.mark.parametrize("grain", [(1, 1), (2, 2)])
def test_blocks_in_step_cost_nothing_and_others_what_the_regularity_is(grain):
    first = (2, -2)
    cost = StepCosts(GRID, (13, 17), grain).at(first)
    rows, columns = np.indices((13, 17))
    down, right = first[0] - rows * grain[0], first[1] - columns * grain[1]
    in_step = (down % 6 == 0) & (right % 8 == 0)
    assert in_step.any()
    np.testing.assert_allclose(cost[in_step], 0, atol=1e-12)
    assert cost[(abs(down % 6 - 3) < 1) | (abs(right % 8 - 4) < 1)].min() > 0.49 * STEP
    assert cost.max() <= 0.5 * STEP


@pytest.mark.parametrize("grain", [(1, 1), (2, 4)])
def test_blocks_cost_the_same_at_an_offset_whichever_corner_has_it(grain):
    steps, costs = StepCosts(GRID, (5, 7), grain), {}
    for down in range(-23, 24):
        for right in range(-31, 32, 3):
            for (row, column), cost in np.ndenumerate(steps.at((down, right))):
                offset = down - row * grain[0], right - column * grain[1]
                assert costs.setdefault(offset, cost) == cost
    other = Lattice(GRID.vectors, 0.25)
    np.testing.assert_allclose(StepCosts(other, (5, 7), grain).at((3, 2)), steps.at((3, 2)) / 2)


def test_blocks_out_of_step_with_rows_cost_the_full_price_wherever_they_lie_along_them():
    cost = StepCosts(Rows(torch.tensor([6.0, 0.0], dtype=torch.float64)), (13, 17), (1, 1)).at((2, -2))
    off = (2 - np.indices((13, 17))[0]) % 6
    np.testing.assert_allclose(cost[off == 0], 0, atol=1e-12)
    np.testing.assert_allclose(cost[off == 3], STEP, rtol=1e-3)


def test_places_charge_for_each_corner_on_the_grain():
    def place(here, there):
        return (there - here[:, None]).sum(-1).float()

    cost = charged([place, place], (1, 2), (3, 4), (2, 5), torch.device("cpu"))
    rows, columns = np.indices((3, 4))
    np.testing.assert_array_equal(cost, 2 * (2 * rows - 1 + 5 * columns - 2))
    assert not charged([], (1, 2), (3, 4), (2, 5), torch.device("cpu")).any()


def test_what_is_shown_nearby_counts_by_its_distance_from_the_box():
    mosaic = Mosaic([np.random.default_rng(0).random((1, 6, 7), dtype=np.float32)])
    sheet = Sheet(mosaic, (9, 11), (False, False), SeamCost(mosaic))
    for start, shift in (((0, 0), (0, 0)), ((4, 5), (3, 4))):
        box = Box(start, (5, 6))
        sheet.lay(Patch(0, shift, box), must=np.ones(box.extent, bool))
    box, reach = Box((2, 3), (3, 4)), 3
    wanted = np.zeros((6, 7))
    for row, column in np.argwhere(sheet.filled):
        away = np.hypot(max(2 - row, row - 4, 0), max(3 - column, column - 6, 0))
        there = mosaic.coordinates(sheet.places[row, column])[1]
        wanted[tuple(there)] += max(1 - away / reach, 0)
    exemplar = Exemplar.of(torch.from_numpy(mosaic.images[0]))
    corners = Corners.fitting(exemplar, (2, reach), (1, 1)).hanging((1, 1))
    none = np.empty((0, mosaic.cell_size), mosaic.place_type)
    corner, here = shown_near(sheet, [Box((6, 8), (3, 4)), box], corners, none)
    np.testing.assert_allclose(here, corners.sums(np.pad(wanted, 1)).ravel(), atol=1e-12)
    np.testing.assert_array_equal(corner, shown_near(sheet, [Box((6, 8), (3, 4))], corners, none)[0])
    assert (wanted > 1).any()


def test_places_of_a_scene_cost_what_they_and_their_kind_are_shown_more_than_all():
    rng = np.random.default_rng(0)
    clip, used = rng.random((2, 3, 9, 16)), rng.integers(0, 4, (3, 9, 16)).astype(float)
    scene = SceneUse(clip, 1.0)
    half, often = AROUND // 2, used.sum(0)
    around = np.pad(often, half, mode="edge")
    near = [[around[y : y + 2 * half + 1, x : x + 2 * half + 1].mean() for x in range(16)] for y in range(9)]
    kind = scene.kind.reshape(9, 16)
    like = np.select([kind == k for k in range(KINDS)], [often[kind == k].mean() for k in range(KINDS)])
    expected = (EVEN * np.array(near) + LIKE * like) / often.mean()
    np.testing.assert_allclose(scene.prices(used), np.broadcast_to(expected, used.shape))
    assert not scene.prices(0 * used).any()


def test_kinds_of_places_are_as_many_each_from_calm_to_steep():
    clip = np.zeros((1, 2, 16, 16))
    clip[..., 8:] = np.random.default_rng(0).random((1, 2, 16, 8)) * np.linspace(0.5, 5, 16)[:, None]
    kind = SceneUse(clip, 3.0).kind
    assert np.bincount(kind).tolist() == [16 * 16 // KINDS] * KINDS
    rows = kind.reshape(16, 16)
    assert rows[:, :5].max() < rows[:, 11:].min()
    assert rows[12:, 11:].mean() > rows[:4, 11:].mean() + 1


def test_uneven_use_of_places_costs_the_more_the_larger_a_scene_is_made():
    clip, used = np.random.default_rng(0).random((1, 2, 6, 8)), np.ones((2, 6, 8))
    once = EVEN + LIKE
    np.testing.assert_allclose(SceneUse.of(clip, (12, 9, 12)).prices(used), 1.25 * once)
    np.testing.assert_allclose(SceneUse.of(clip, (24, 6, 16)).prices(used), once)
    assert SceneUse.of(clip, (24, 6, 8)) is SceneUse.of(clip, (5, 3, 8)) is None
