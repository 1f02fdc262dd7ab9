"""Smaller blocks, where large ones miss a guide."""

import pytest
import torch
from made import MADE

from kwatra import Exemplar
from kwatra.pieces import BlockStart, blocks, offers
from kwatra.terms.controls import Wish


def laid(exemplar, value, weight, seed=0):
    """The source map of blocks of 24 pixels, 72x72, that are wished to have values where weights are."""
    wish = Wish(weight.expand_as(value).contiguous(), value)
    generator = torch.Generator().manual_seed(seed)
    return BlockStart(exemplar, (72, 72), (24, 24), (1, 1), generator, usage=0.35, seams=6, wish=wish).run()


def guided(seed):
    """Coins of 12 px, a map that rises from left to right, and what it misses where it is to rise around a center."""
    coins = MADE["coins"](96, 12, seed).image
    image = torch.cat([coins, torch.linspace(0, 1, 96).expand(1, 96, 96)])
    y, x = torch.meshgrid(torch.linspace(-1, 1, 72), torch.linspace(-1, 1, 72), indexing="ij")
    value = torch.cat([torch.zeros(len(coins), 72, 72), torch.hypot(y, x)[None] / 1.5])
    weight = (torch.arange(len(value)) == len(coins)).float().view(-1, 1, 1)

    def missed(by_much):
        offers.MISSED_BY_MUCH = by_much
        where = laid(Exemplar.of(image), value, weight, seed)
        return float((image[-1][where[0], where[1]] - value[-1]).abs().mean())

    return missed


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_smaller_blocks_follow_a_guide_more_closely(seed, monkeypatch):
    monkeypatch.setattr(offers, "MISSED_BY_MUCH", offers.MISSED)
    missed = guided(seed)
    with_them = missed(offers.MISSED)
    monkeypatch.setattr(blocks, "FOLLOWING", ())
    assert with_them < 0.07
    assert with_them < 0.85 * missed(offers.MISSED)


@pytest.mark.parametrize("seed", [0, 2])
def test_blocks_smaller_than_an_element_are_laid_only_where_much_is_missed(seed, monkeypatch):
    monkeypatch.setattr(offers, "MISSED_BY_MUCH", offers.MISSED_BY_MUCH)
    missed = guided(seed)
    everywhere, nowhere = missed(offers.MISSED), missed(1e9)
    assert everywhere < 0.95 * nowhere
    assert missed(0.5) > everywhere


def test_smaller_blocks_are_of_a_share_of_the_size_and_lie_all_over_the_same_sheet():
    exemplar = Exemplar.of(torch.rand(1, 60, 60, generator=torch.Generator().manual_seed(0)))
    start = BlockStart(exemplar, (80, 90), (32, 24), (1, 1), torch.Generator().manual_seed(0), usage=0.35, seams=1)
    small = start.layer.smaller(0.25)
    assert small.corners.block == (8, 6)
    assert small.sheet is start.sheet
    covered = torch.zeros(80, 90, dtype=torch.bool)
    for box in small.boxes:
        covered[tuple(slice(a, b) for a, b in zip(box.start, box.stop, strict=True))] = True
    assert bool(covered.all())
    assert start.layer.corners.block == (32, 24)
