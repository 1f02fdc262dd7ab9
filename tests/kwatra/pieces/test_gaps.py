import pytest
import torch
from bench_elements import cut_elements
from made import MADE

from kwatra import Blocks, Exemplar
from kwatra.pieces import BlockStart, gaps


def cut(made, monkeypatch=None):
    """The share of elements that blocks of a texture cut; with the patch, where gaps are not heeded."""
    if monkeypatch is not None:
        monkeypatch.setattr("kwatra.pieces.blocks.gaps", lambda *_: None)
    generator = torch.Generator().manual_seed(0)
    start = BlockStart(Exemplar.of(made.image), (192, 192), (80, 80), (1, 1), generator, how=Blocks())
    where = start.run()
    return cut_elements(made.numbers.numpy(), (where[0] * 128 + where[1]).numpy())["cut"]


@pytest.mark.parametrize(("name", "most"), [("coins", 0.1), ("stones", 0.25)])
def test_elements_stay_whole_where_there_are_gaps(name, most, monkeypatch):
    made = MADE[name](128, 24, 0)
    whole, torn = cut(made), cut(made, monkeypatch)
    assert whole <= most
    assert whole < torn


def test_noise_has_no_gaps():
    noise = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    start = BlockStart(Exemplar.of(noise), (64, 64), (16, 16), (1, 1), torch.Generator().manual_seed(0), how=Blocks())
    assert gaps(start.exemplar, start.sheet.sources, 1.0) is None
