"""Directions: none in noise, one in stripes and under light from a side, four in a grid, six in hexagons."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import torch
from scipy import ndimage
from skimage import data
from torch import Tensor

from kwatra import Exemplar, direction_dependence
from kwatra.elements import direction

SIDE = 96


def waves(*degrees: float) -> Tensor:
    """Waves that cross at angles: (1, SIDE, SIDE)."""
    y, x = torch.meshgrid(torch.arange(SIDE), torch.arange(SIDE), indexing="ij")
    crossed = [torch.cos(0.8 * (x * math.cos(math.radians(d)) + y * math.sin(math.radians(d)))) for d in degrees]
    return torch.stack(crossed).mean(0, keepdim=True) / 2 + 0.5


def noise(width: float = 2.0) -> Tensor:
    rough = ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(SIDE, SIDE)), width, mode="wrap")
    return torch.from_numpy((rough - rough.min()) / np.ptp(rough)).float()[None]


def lit() -> Tensor:
    """Hills that rise slowly to the right and fall steeply: their slopes' strengths differ with the direction."""
    x = torch.arange(SIDE) % 16
    return torch.where(x < 13, x / 13, (16 - x) / 3).float().expand(1, SIDE, SIDE)


@pytest.mark.parametrize(
    ("texture", "least", "most"),
    [
        (lambda: noise(), 0.0, 0.15),
        (lambda: torch.from_numpy(data.gravel()[:256, :256].astype(np.float32) / 255)[None], 0.0, 0.15),
        (lambda: waves(20.0), 0.9, 1.0),
        (lambda: waves(10.0, 100.0), 0.4, 1.0),
        (lambda: torch.stack([(waves(d) > 0.95).float() for d in (5.0, 65.0, 125.0)]).amax(0), 0.2, 1.0),
        (lit, 0.5, 1.0),
        (lambda: torch.full((3, 40, 40), 0.5), 0.0, 0.0),
    ],
    ids=["noise", "gravel", "stripes", "grid", "hexagons", "lit", "flat"],
)
def test_it_is_large_where_edges_prefer_directions(texture: Callable[[], Tensor], least: float, most: float) -> None:
    assert least <= direction_dependence(Exemplar.of(texture())) <= most


def bars(ways: Sequence[float], seed: int) -> Tensor:
    """4 x 4 bars, 24 px apart, each with the angle of one of some ways, in degrees, drawn at random: (1, 96, 96)."""
    angle = np.radians(np.random.default_rng(seed).choice(ways, (4, 4)))
    y, x = np.mgrid[:24, :24] - 11.5
    rows = [[np.exp(-((x * np.cos(a) + y * np.sin(a)) ** 2) / 8 - (x**2 + y**2) / 50) for a in line] for line in angle]
    return torch.from_numpy(np.block(rows)).float()[None]


def test_what_few_elements_have_by_chance_is_taken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 16 bars that lie anyhow edges prefer one direction by chance; of 16 that lie one way they do, and no less."""
    pictures = [[bars(ways, seed) for seed in range(8)] for ways in (np.arange(0.0, 180.0, 5.0), (30.0,))]
    anyhow, one_way = ([direction_dependence(Exemplar.of(image)) for image in images] for images in pictures)
    monkeypatch.setattr(direction, "CHANCE", 0.0)
    chance, before = ([direction_dependence(Exemplar.of(i.clone())) for i in images] for images in pictures)
    assert sum(value > 0.1 for value in chance) >= 6
    assert sum(value > 0.1 for value in anyhow) <= 1
    assert min(before) > 0.5
    assert one_way == pytest.approx(before, rel=0.01)


def test_of_a_large_picture_directions_are_told_where_it_is_coarser(monkeypatch: pytest.MonkeyPatch) -> None:
    found = direction_dependence(Exemplar.of(waves(20.0, 70.0)))
    monkeypatch.setattr(direction, "LOOKED_AT", SIDE**2)
    large = waves(20.0, 70.0).repeat_interleave(2, 1).repeat_interleave(2, 2)
    assert direction_dependence(Exemplar.of(large)) == found
    monkeypatch.setattr(direction, "LOOKED_AT", 4 * SIDE**2)
    assert direction_dependence(Exemplar.of(large)) != found


def test_turning_an_exemplar_changes_nothing() -> None:
    found = direction_dependence(Exemplar.of(waves(20.0, 70.0)))
    assert direction_dependence(Exemplar.of(waves(20.0, 70.0).transpose(1, 2))) == pytest.approx(found, rel=1e-4)


def test_what_is_masked_does_not_count() -> None:
    """Noise, with stripes behind the mask."""
    mask = torch.ones(SIDE, SIDE, dtype=torch.bool)
    mask[:, 60:] = False
    image, other = (torch.where(mask, noise(), hidden) for hidden in (waves(0.0), waves(90.0)))
    found = direction_dependence(Exemplar.of(image, masks=[mask]))
    assert found < 0.2
    assert direction_dependence(Exemplar.of(other, masks=[mask])) == found


def test_videos_have_none() -> None:
    assert direction_dependence(Exemplar.of(waves(20.0)[:, None].repeat(1, 3, 1, 1))) == 0
