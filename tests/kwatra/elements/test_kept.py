import time
from dataclasses import replace

import torch

from kwatra import Exemplar
from kwatra.base import shared
from kwatra.elements.kept import kept


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
