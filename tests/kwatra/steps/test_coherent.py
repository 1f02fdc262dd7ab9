"""Coherent candidates, in one pass over a grid, against its neighbors one by one."""

import pytest
import torch

from kwatra import Exemplar
from kwatra.base import generator_of
from kwatra.source import Bag, SourceWindows
from kwatra.steps import coherent as module
from kwatra.steps.coherent import coherent, nearest_coherent
from kwatra.steps.inplace import nearest_in_place
from kwatra.windows import Grid, channels_last
from kwatra.windows.flat import continued


@pytest.mark.parametrize("wrap", [False, True, (True, False)])
@pytest.mark.parametrize("part", [slice(None), slice(37, 95), slice(5, 5)])
@pytest.mark.parametrize("holes", [False, True])
def test_one_pass_over_a_grid_finds_what_its_neighbors_give_one_by_one(wrap, part, holes, monkeypatch):
    usable = torch.ones(24, 30, dtype=torch.bool)
    if holes:
        usable[10:13, 4:9] = False
    source = SourceWindows(Exemplar.of(torch.rand(3, 24, 30), masks=[usable]), (6, 4), generator_of(0))
    grid = Grid((31, 26), (6, 4), (2, 2), wrap)  # the last of a plain grid are not a step from those before
    matches = source.numbers[torch.randint(len(source.numbers), (len(grid),), generator=generator_of(1))]
    found = coherent(grid, source, matches, part)
    monkeypatch.setattr(module, "fits", lambda source: False)
    assert torch.equal(found, coherent(grid, source, matches, part))
    assert found.shape == (len(range(*part.indices(len(grid)))), 5)
    assert torch.isin(found, source.numbers).all()


def test_windows_of_a_video_have_two_neighbors_along_each_axis(monkeypatch):
    source = SourceWindows(Exemplar.of(torch.rand(1, 9, 12, 11)), (3, 4, 4), generator_of(0))
    grid = Grid((8, 13, 12), (3, 4, 4), (1, 2, 2), (True, False, True))
    matches = source.snapped(grid.corners)
    found = coherent(grid, source, matches, slice(None))
    monkeypatch.setattr(module, "fits", lambda source: False)
    assert torch.equal(found, coherent(grid, source, matches, slice(None)))
    assert found.shape[1] == 7


def test_of_a_copy_that_goes_on_all_candidates_are_one():
    source = SourceWindows(Exemplar.of(torch.rand(3, 40, 40)), (8, 8), generator_of(0))
    grid = Grid((24, 28), (8, 8), (2, 2))
    matches = source.snapped(grid.corners + 5)
    assert torch.equal(coherent(grid, source, matches, slice(None)), matches[:, None].expand(-1, 5))


def test_windows_without_a_place_have_no_neighbors():
    bag = Bag(torch.rand(9, 4, 4, 3), torch.ones(3), generator_of(0))
    matches = torch.arange(9)[torch.randint(9, (25,), generator=generator_of(1))]
    assert torch.equal(coherent(Grid((8, 8), (4, 4), (1, 1)), bag, matches, slice(3, 9)), matches[3:9, None])


@pytest.mark.parametrize("wrap", [False, True, (True, False)])
@pytest.mark.parametrize("settled", [0.0, 0.08, 1e9])
def test_candidates_looked_up_one_by_one_are_compared_as_all_at_once_are(wrap, settled):
    usable = torch.ones(24, 30, dtype=torch.bool)
    usable[10:13, 4:9] = False
    source = SourceWindows(Exemplar.of(torch.rand(3, 24, 30), masks=[usable]), (6, 4), generator_of(0))
    grid = Grid((31, 26), (6, 4), (2, 2), wrap)
    matches = source.numbers[torch.randint(len(source.numbers), (len(grid),), generator=generator_of(1))]
    pixels = continued(channels_last(torch.rand(3, 31, 26, generator=generator_of(2))), grid)
    number, squared = nearest_coherent(pixels, grid, source, matches, settled)
    candidates = coherent(grid, source, matches, slice(None))
    every, least = nearest_in_place(pixels, grid.corners, source, candidates, settled)
    assert torch.equal(number, every)
    assert torch.allclose(squared, least, atol=1e-7)
    assert torch.equal(number, matches) == (settled == 1e9)


def test_of_a_video_as_well():
    source = SourceWindows(Exemplar.of(torch.rand(1, 9, 12, 11)), (3, 4, 4), generator_of(0))
    grid = Grid((8, 13, 12), (3, 4, 4), (1, 2, 2), (True, False, True))
    matches = source.numbers[torch.randint(len(source.numbers), (len(grid),), generator=generator_of(1))]
    pixels = continued(channels_last(torch.rand(1, 8, 13, 12, generator=generator_of(2))), grid)
    number, _ = nearest_coherent(pixels, grid, source, matches, 0.0)
    candidates = coherent(grid, source, matches, slice(None))
    assert torch.equal(number, nearest_in_place(pixels, grid.corners, source, candidates)[0])
    assert not torch.equal(number, matches)
