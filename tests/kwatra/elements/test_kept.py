from dataclasses import replace

import torch

from kwatra import Exemplar
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
