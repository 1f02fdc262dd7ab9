"""EM leaves what it would harm: seams that are seen less than those that it makes of them."""

from importlib import import_module

import pytest
import torch

from kwatra import Exemplar, Settings, SoftPixels, begin, improve, optimize
from kwatra.pieces import visible_seams

NOISE = Exemplar.of(torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0)))


@pytest.fixture
def as_em_has_it(monkeypatch):
    """Called, has all be taken that EM makes from then on."""

    def all_later(exemplar, before, after, wraps):
        return torch.ones_like(before[0], dtype=torch.bool)

    return lambda: monkeypatch.setattr(import_module("kwatra.loop.optimize"), "less_seen", all_later)


@pytest.mark.parametrize("wrap", [False, True])
def test_seams_of_the_result_are_seen_less_than_those_it_began_with_and_those_of_em(wrap, as_em_has_it):
    beginning = begin(NOISE, (64, 64), Settings(wrap=wrap))
    assert beginning.gaps is None
    kept = visible_seams(NOISE, improve(beginning).where)
    as_em_has_it()
    assert kept < min(visible_seams(NOISE, beginning.where), visible_seams(NOISE, improve(beginning).where))


def test_what_a_term_asks_for_is_made_whatever_its_seams(as_em_has_it):
    terms = SoftPixels(torch.ones(1, 64, 64), torch.full((1, 64, 64), 2.0))
    made = optimize(NOISE, (64, 64), terms=terms)
    as_em_has_it()
    assert torch.equal(made.image, optimize(NOISE, (64, 64), terms=terms).image)


def test_behind_a_mask_nothing_is_put_back():
    mask = torch.zeros(64, 64, dtype=torch.bool)
    mask[:, :32] = True
    made = optimize(NOISE, (64, 64), mask=mask)
    assert (made.image[:, ~mask] == 0).all()
    assert (made.image[:, mask] != 0).any()
