from itertools import pairwise

import pytest
import torch
from made import MADE

from kwatra import THESIS, Exemplar, InputError, Level, element_size
from kwatra.levels import planned_levels


def checkerboard(size, period):
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    return (((y // (period // 2)) + (x // (period // 2))) % 2).float()[None]


def holed(size, share=0.3):
    """True outside of holes of 6x6 pixels that cover about a share of the picture."""
    seeds = torch.rand(1, 1, size, size, generator=torch.Generator().manual_seed(1)) < share / 36
    return torch.nn.functional.max_pool2d(seeds.float(), 7, 1, 3)[0, 0] == 0


@pytest.mark.parametrize("period", [8, 16, 24])
def test_the_element_is_seen_between_holes_whatever_they_hold(period):
    mask, picture = holed(128), checkerboard(128, period)
    assert 0.6 < float(mask.float().mean()) < 0.85
    noise = torch.rand(1, 128, 128, generator=torch.Generator().manual_seed(2))
    ramp = torch.linspace(0, 50, 128).expand(1, 128, 128)
    for hole in (noise, ramp, torch.zeros(1)):
        exemplar = Exemplar.of([torch.where(mask, picture, hole)], masks=[mask])
        assert element_size(exemplar) == pytest.approx(period / 2, abs=1)


def blobs(size, width):
    noise = torch.rand(1, 1, size + width - 1, size + width - 1, generator=torch.Generator().manual_seed(0))
    return torch.nn.functional.avg_pool2d(noise, width, 1)[0]


def test_what_stands_in_a_hole_or_a_gap_has_no_influence_on_the_levels():
    mask, picture = torch.ones(160, 160, dtype=torch.bool), blobs(160, 3)
    mask[40:110, 50:110] = False

    def plan(*pictures, **copies):
        return planned_levels(Exemplar.of(pictures, **copies), (256, 256), 3)

    plans = [plan(torch.where(mask, picture, hole), masks=[mask]) for hole in (0.5, 90.0)]
    assert plans[0] == plans[1]
    assert plan(picture, picture[:, :40, :60]) == plan(picture[:, :40, :60], picture) == plan(picture)
    assert plan(picture + 8, rotate=[33]) == plan(picture)


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
    with pytest.raises(InputError, match="the exemplar is 40x3 pixels; at least 4x4 are needed"):
        planned_levels(Exemplar.of(torch.rand(1, 3, 40)), (64, 64), 2)
    with pytest.raises(InputError, match="the output is 2x64 pixels; at least 4x4 are needed"):
        planned_levels(Exemplar.of(torch.rand(1, 40, 40)), (64, 2), 2)


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
