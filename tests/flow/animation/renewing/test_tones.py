"""Tones: equally many pixels of each class, and a price on those shown too often."""

import math
from itertools import pairwise

import pytest
import torch
from torch import Tensor

from flow.animation.renewing.tones import Tones
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar

SIDE = 64
WHOLE = torch.ones(SIDE, SIDE, dtype=torch.bool)
ALL = pixel_coordinates((SIDE, SIDE))


def noise(channels: int = 3) -> Tensor:
    return torch.rand(channels, SIDE, SIDE, generator=torch.Generator().manual_seed(2))


def priced(source: Tensor, inside: Tensor) -> Tensor:
    tones = Tones(Exemplar.of(noise()), 1.0)
    return tones.prices(tones.of(source), inside)


def test_the_exemplar_has_equally_many_pixels_of_each_tone() -> None:
    tones = Tones(Exemplar.of(noise()), 1.0)
    assert torch.equal(torch.bincount(tones.of(ALL).flatten()), torch.full((16,), SIDE * SIDE // 16))


def test_tones_follow_brightness() -> None:
    ramp = torch.linspace(0, 1, SIDE).expand(1, SIDE, SIDE)
    tone = Tones(Exemplar.of(ramp), 1.0).of(ALL).float().mean(0)
    assert bool((tone.diff() >= 0).all()) or bool((tone.diff() <= 0).all())
    assert float(tone.amax() - tone.amin()) > 14


def test_the_pixels_of_a_tone_are_sorted_by_grain() -> None:
    image, grain = noise(), noise(1)[0]
    tones = Tones(Exemplar.of(image), 1.0, grain)
    kinds = tones.of(ALL)
    assert torch.equal(torch.bincount(kinds.flatten()), torch.full((32,), SIDE * SIDE // 32))
    assert torch.equal(kinds // 4, Tones(Exemplar.of(image), 1.0).of(ALL) // 2)
    for tone in range(8):
        grades = [grain[kinds == 4 * tone + grade] for grade in range(4)]
        assert all(float(low.max()) <= float(high.min()) for low, high in pairwise(grades))
    x, y = (kinds % 4 == 0).nonzero().T.flip(0).float()
    smooth = torch.stack([x, y]).repeat(1, 4).view(2, SIDE, SIDE)
    prices = tones.prices(tones.of(smooth), WHOLE)
    assert prices[::4].tolist() == pytest.approx([math.log(4)] * 8, abs=0.02)
    assert prices.view(8, 4)[:, 1:].flatten().tolist() == pytest.approx([math.log(0.1)] * 24)


def test_a_channel_that_does_not_count_has_no_tone() -> None:
    image = noise(2)
    image[1] *= 100
    counted = Tones(Exemplar.of(image, weights=[1.0, 0.0]), 1.0).of(ALL)
    alone = Tones(Exemplar.of(image[:1]), 1.0).of(ALL)
    assert torch.equal(counted, alone) or torch.equal(counted, 15 - alone)


def test_the_exemplar_itself_costs_nothing() -> None:
    assert float(priced(ALL, WHOLE).abs().max()) == 0


def test_each_pixel_of_the_exemplar_costs_its_tones_price() -> None:
    tones, prices = Tones(Exemplar.of(noise()), 1.0), torch.arange(16.0)
    assert torch.equal(tones.costs(prices, torch.arange(len(ALL[0]))), tones.of(ALL).float())


def test_a_tone_shown_too_often_costs_the_logarithm_of_how_often() -> None:
    tones = Tones(Exemplar.of(noise()), 0.5)
    kind = tones.of(ALL)
    y, x = (kind == 3).nonzero()[0]
    source = ALL.clone()
    cover = torch.zeros_like(WHOLE)
    cover[:16] = True
    source[0, cover], source[1, cover] = float(x), float(y)
    prices = tones.prices(tones.of(source), WHOLE)
    share = 16 * (tones.of(source) == 3).float().mean()
    assert float(share) > 4
    assert float(prices[3]) == pytest.approx(0.5 * math.log(float(share)), rel=1e-5)
    assert float(prices[[k for k in range(16) if k != 3]].max()) <= 0
    only = tones.prices(tones.of(source), ~cover)
    rest = 16 * (kind[~cover] == 3).float().mean()
    assert float(only[3]) == pytest.approx(0.5 * math.log(float(rest)), abs=1e-6)


def test_an_empty_frame_has_prices() -> None:
    assert bool(priced(ALL, ~WHOLE).isfinite().all())


def test_holes_have_no_tone() -> None:
    hole = torch.zeros(SIDE, SIDE, dtype=torch.bool)
    hole[20:40, 20:40] = True
    image = noise()
    spoiled = torch.where(hole, 50.0, image)
    clean, other = (Tones(Exemplar.of(v, masks=[~hole]), 1.0).of(ALL)[~hole] for v in (image, spoiled))
    assert torch.equal(clean, other)
    assert float(torch.bincount(clean).float().std()) < 1


def test_what_a_clips_frames_vary_by_anyway_costs_nothing() -> None:
    bright, dark = torch.full((1, SIDE // 2, SIDE), 0.9), torch.full((1, SIDE // 2, SIDE), 0.1)
    clip = Exemplar.of(torch.cat([bright, dark], 1) + 0.01 * noise(1))
    top = ALL[:, : SIDE // 2].repeat(1, 2, 1)
    still, living = Tones(clip, 1.0), Tones(clip, 1.0, frames=2)
    assert float(still.prices(still.of(top), WHOLE).max()) == pytest.approx(math.log(2), abs=0.02)
    assert (
        float(living.prices(living.of(top), WHOLE).abs().max())
        < float(still.prices(still.of(top), WHOLE).abs().max()) / 2
    )
    one = (living.of(ALL) == living.of(ALL).max()).nonzero()[0].flip(0).float()
    prices = living.prices(living.of(one.view(2, 1, 1).expand(2, SIDE, SIDE)), WHOLE)
    own = (math.log(2) - math.log(0.1)) / 2  # half of what its logarithm is larger by in the first frame
    assert float(prices.max()) == pytest.approx(math.log(16) - own, abs=0.02)
