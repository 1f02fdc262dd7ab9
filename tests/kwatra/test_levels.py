from itertools import pairwise

import pytest
import torch
from made import MADE

from kwatra import THESIS, Exemplar, InputError, Level, texture_element
from kwatra.levels import planned_levels


def checkerboard(size, period):
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    return (((y // (period // 2)) + (x // (period // 2))) % 2).float()[None]


@pytest.mark.parametrize("period", [8, 16, 24])
def test_the_element_of_a_periodic_texture_is_its_period(period):
    assert texture_element(checkerboard(128, period)) == pytest.approx(period, abs=1)


def test_the_element_grows_with_the_blobs():
    noise = torch.rand(1, 1, 128, 128, generator=torch.Generator().manual_seed(0))
    sizes = [texture_element(torch.nn.functional.avg_pool2d(noise, k, 1)[0]) for k in (3, 7, 15)]
    assert sizes == sorted(sizes)
    assert sizes[0] < 12 < 24 < sizes[2]


def test_a_constant_texture_has_the_smallest_element():
    assert texture_element(torch.full((3, 32, 32), 0.4)) == 2.0


def test_planned_levels_run_coarse_to_fine_and_large_to_small():
    levels = planned_levels(Exemplar.of(checkerboard(128, 16)), (256, 256), 3)
    factors = [level.factor for level in levels]
    assert factors == sorted(factors, reverse=True)
    assert factors[0] == 4
    assert factors[-1] == 1
    for a, b in pairwise(levels):
        assert a.factor > b.factor or a.width > b.width


@pytest.mark.parametrize("size", [4, 7, 12, 30, 60])
def test_small_exemplars_get_levels_that_fit(size):
    for level in planned_levels(Exemplar.of(torch.rand(1, size, size)), (64, 64), 2):
        assert level.width * level.factor <= size or (level.factor == 1 and level.width <= size)


def test_thesis_levels_are_those_of_figure_23():
    assert [(level.factor, level.width) for level in THESIS] == [(4, 8), (2, 16), (2, 8), (1, 32), (1, 16), (1, 8)]


def test_time_is_never_subsampled():
    assert Level(4, 16).factors(3) == (1, 4, 4)
    assert Level(4, 16).window(3) == (4, 16, 16)
    assert Level(4, 16).window(2) == (16, 16)


def test_levels_that_cannot_be_are_refused():
    with pytest.raises(InputError, match="allowed are 1, 2, 4 and 8"):
        Level(3, 8)
    with pytest.raises(InputError, match="a width of at least 2"):
        Level(1, 1)
    with pytest.raises(InputError, match="route is 'guess'"):
        Level(1, 8, route="guess")
    with pytest.raises(InputError, match="at least 4 are needed"):
        planned_levels(Exemplar.of(torch.rand(1, 3, 40)), (64, 64), 2)


def test_windows_that_do_not_fit_between_holes_are_not_planned():
    mask = torch.ones(128, 128, dtype=torch.bool)
    mask[::12] = False  # strips of 11 rows between the holes
    image = torch.rand(1, 128, 128, generator=torch.Generator().manual_seed(0))
    levels = planned_levels(Exemplar.of([image], masks=[mask]), (64, 64), 3)
    assert [(level.factor, level.width) for level in levels] == [(1, 8)]
    mask[::6] = False
    levels = planned_levels(Exemplar.of([image], masks=[mask]), (64, 64), 3)
    assert [(level.factor, level.width) for level in levels] == [(1, 4)]
    mask[::3] = False
    with pytest.raises(InputError, match="no 4x4 window fits between the exemplar's holes"):
        planned_levels(Exemplar.of([image], masks=[mask]), (64, 64), 3)


def test_the_coarsest_window_spans_elements_of_one_brightness():
    stones = MADE["stones"](192, 48).image
    hidden = torch.ones(192, 192, dtype=torch.bool)
    hidden[60:100, 60:100] = False
    painted = torch.where(hidden, stones, 9 * checkerboard(192, 8))
    for exemplar in (Exemplar.of(stones), Exemplar.of(painted, masks=[hidden])):
        level = planned_levels(exemplar, (256, 256), 3)[0]
        assert (level.factor, level.width) == (4, 12)
