import time
from dataclasses import replace

import torch

from kwatra import Exemplar
from kwatra.base import shared
from kwatra.elements.correlation import SMALL, of_colors, of_edges
from kwatra.elements.kept import kept, kept_up_to


def test_what_is_found_of_an_exemplar_is_found_once():
    asked = []

    @kept
    def find(exemplar):
        asked.append(exemplar)
        return len(asked)

    one, other = (Exemplar.of(torch.rand(1, 8, 8)) for _ in range(2))
    assert [find(one), find(other), find(one), find(other)] == [1, 2, 1, 2]
    masked = replace(one, owner=torch.full_like(one.owner, -1.0))
    assert find(masked) == 3  # the same canvas, of which less is texture
    assert find(one.coarser((1, 1))) == find(one)


def test_what_is_found_of_a_large_exemplar_need_not_be_kept():
    asked = []

    @kept_up_to(64)
    def find(exemplar):
        asked.append(exemplar)
        return len(asked)

    small, large = Exemplar.of(torch.rand(3, 8, 8)), Exemplar.of(torch.rand(1, 8, 9))
    assert [find(small), find(large), find(small), find(large)] == [1, 2, 1, 3]


def test_autocorrelations_of_large_exemplars_are_let_go():
    """Two doubles for each lag, of which there are three times as many as pixels: too much to hold."""
    width = SMALL // 8
    small, large = Exemplar.of(torch.rand(1, 8, width)), Exemplar.of(torch.rand(1, 8, width + 1))
    for find in (of_colors, of_edges):
        assert find(small) is find(small)
        assert find(large) is not find(large)


def test_threads_that_ask_at_once_find_it_once():
    asked = []

    @kept
    def find(exemplar):
        time.sleep(0.02)
        asked.append(exemplar)
        return len(asked)

    one = Exemplar.of(torch.rand(1, 8, 8))
    torch.set_num_threads(3)
    assert shared(lambda number: find(one), range(6)) == [1] * 6
