"""Blocks whose cut promises little are not measured, which is most of what a block costs."""

import math

import pytest
import torch

from flow.animation.film.film import Film
from flow.animation.renewing.renewal import Renewal
from flow.animation.settings import Renewing
from flow.warps import pixel_coordinates
from kwatra import Exemplar

SHAPE = (40, 44)


@pytest.mark.parametrize(("share", "least", "most"), [(1e9, 0, 0), (0.0, 1, 6)])
def test_a_block_that_promises_little_is_not_measured(
    share: float, least: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    noise = torch.rand(1, 16, 16, generator=torch.Generator().manual_seed(0))
    stones = torch.nn.functional.interpolate(noise[None], (80, 80), mode="bicubic")[0].clamp(0, 1)
    renewal = Renewal(Film.of(Exemplar.of(stones), turn=False), SHAPE, Renewing(blocks=6, block=20, window=12, step=6))
    measured: list[int] = []
    monkeypatch.setattr("flow.animation.renewing.renewal._PROMISE", share)
    monkeypatch.setattr(renewal.wear, "after", lambda worn, *_: measured.append(1) or worn)
    (x, y), cos, sin = pixel_coordinates(SHAPE), math.cos(0.5), math.sin(0.5)
    turned = torch.stack([cos * x - sin * y + 30, sin * x + cos * y + 5])
    renewal(turned, torch.ones(SHAPE, dtype=torch.bool), torch.Generator().manual_seed(0))
    assert least <= len(measured) <= most
