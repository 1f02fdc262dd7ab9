"""What the switches of a synthesis of neighborhoods ask of the engine."""

from itertools import product
from unittest.mock import Mock

import pytest
import torch

from kwatra import Mode, Settings, mean
from synth.metamorphosis.patches import synthesis
from synth.metamorphosis.patches.centers import BestCenters, regular
from synth.metamorphosis.patches.relaxation import Relaxed
from synth.metamorphosis.patches.weighting import Weighting


class Asked(Exception):
    """The engine was asked."""


@pytest.mark.parametrize(("centers", "relaxed", "mode"), [*product((False, True), repeat=3)])
def test_each_switch_turns_its_own_part(
    monkeypatch: pytest.MonkeyPatch, centers: bool, relaxed: bool, mode: bool
) -> None:
    def asked(*_: object, settings: Settings, **__: object) -> None:
        raise Asked(settings)

    monkeypatch.setattr(synthesis, "optimize", asked)
    monkeypatch.setattr(synthesis, "_bag", lambda *_: (torch.zeros(4, 8, 8, 4), torch.arange(4)))
    own = synthesis.Synthesis(iterations=2, free_centers=centers, relaxed=relaxed, mean_shift=mode)
    levels, even = [Mock(level=(1, 8), feature_weight=1.0)], Weighting.even((0.5, 0.5), (16, 16))
    with pytest.raises(Asked) as raised:
        own(levels, even, torch.zeros(4, 16, 16), False, 0, Mock())
    settings = raised.value.args[0]
    assert isinstance(settings.layout, BestCenters) if centers else settings.layout is regular
    assert isinstance(settings.vote, Relaxed) == relaxed
    vote = settings.vote.vote._vote if relaxed else settings.vote._vote
    assert isinstance(vote, Mode) if mode else vote is mean
    assert settings.levels[0].iterations == 2
