"""Whose threads work on a level, as a vote is told."""

import pytest
import torch

from kwatra import Exemplar, Level, Settings, SoftPixels, optimize
from kwatra.base import generator_of, threads_shared
from kwatra.steps import mean


def seen(route, size=(40, 44), channels=(1,), **more):
    """How many threads torch and `shared` have in the last blend."""
    found = []

    def vote(ballot):
        found.append((torch.get_num_threads(), threads_shared()))
        return mean(ballot)

    texture = torch.rand(*channels, *(n + 4 for n in size), generator=generator_of(0))
    optimize(Exemplar.of(texture), size, settings=Settings(levels=(Level(1, 8, 2, route=route),), vote=vote), **more)
    return found[-1]


@pytest.fixture(autouse=True)
def two_threads():
    torch.set_num_threads(2)


def test_ours_where_a_still_goes_by_coherence():
    assert seen("coherent") == (1, 2)
    assert torch.get_num_threads() == threads_shared() == 2


def test_torch_s_where_an_index_is_searched_something_steers_or_it_is_a_video():
    assert seen("exact") == (2, 2)
    assert seen("coherent", terms=SoftPixels(torch.zeros(1, 40, 44), torch.ones(1, 40, 44))) == (2, 2)
    assert seen("coherent", mask=torch.arange(44).expand(40, 44) > 3) == (2, 2)
    assert seen("coherent", size=(8, 24, 26)) == (2, 2)


def test_torch_s_where_something_is_done_between():
    assert seen("coherent", between=lambda image, step: image) == (2, 2)
