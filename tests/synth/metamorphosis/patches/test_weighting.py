"""Weights of textures and maps of them, and the pace at which weights turn one into another."""

from unittest.mock import Mock

import pytest
import torch

from kwatra import InputError
from synth.metamorphosis.bands import Bands
from synth.metamorphosis.patches.pace import Pace
from synth.metamorphosis.patches.weighting import STEPS, Weighting, checked_weights, simplex


@pytest.mark.parametrize(("count", "known"), [(2, 21), (3, 36), (4, 35), (6, 21)])
def test_weightings_are_spread_over_all_there_are(count: int, known: int) -> None:
    points = torch.tensor(simplex(count))
    assert len(points) == known <= STEPS
    assert torch.allclose(points.sum(1), torch.ones(known))
    assert len({tuple(point) for point in points.tolist()}) == known
    corners = {tuple(row) for row in torch.eye(count).tolist()}
    assert corners <= {tuple(point) for point in points.tolist()}


def test_maps_are_made_to_sum_to_1_and_told_apart() -> None:
    maps = torch.stack([torch.full((4, 5), 3.0), torch.zeros(4, 5)])
    maps[1, :, 3:] = 3.0
    made = Weighting.of(maps)
    assert torch.allclose(made.values.sum(0), torch.ones(4, 5))
    assert set(made.palette) == {(1.0, 0.0), (0.5, 0.5)}
    assert made.palette[int(made.nearest[0, 0])] == (1.0, 0.0)
    assert made.palette[int(made.nearest[0, 4])] == (0.5, 0.5)
    # by the middle of a window, here its third pixel
    assert made.at(torch.tensor([[0, 0], [0, 1], [0, 2]]), 4).tolist() == made.nearest[2, 2:].tolist()


def test_the_steepest_change_is_that_to_the_next_pixel() -> None:
    maps = torch.zeros(2, 1, 9)
    maps[1, 0] = torch.tensor([0, 0.1, 0.2, 0.3, 0.7, 0.8, 0.9, 1, 1])
    maps[0] = 1 - maps[1]
    assert Weighting.of(maps).steepest == pytest.approx(0.4)
    assert Weighting.of(maps.mT).steepest == pytest.approx(0.4)


def test_the_slope_is_the_mean_change_of_what_is_of_several() -> None:
    maps = torch.zeros(2, 12, 30)
    maps[1, :, 10:20], maps[1, :, 20:] = torch.linspace(0.05, 0.95, 10), 1.0
    maps[0] = 1 - maps[1]
    assert Weighting.of(maps).slope == pytest.approx((8 * 0.1 + 2 * 0.075) / 10)  # ends are .05 from what is beyond
    assert Weighting.of(maps.mT).slope == pytest.approx(Weighting.of(maps).slope)
    assert Weighting.of(maps.round()).slope == Weighting.even((0.5, 0.5), (12, 30)).slope == 0


def test_purity_is_1_where_one_texture_is_alone_and_0_where_all_are_alike() -> None:
    maps = torch.zeros(3, 8, 40)
    maps[:, :, :20], maps[1, :, 20:] = 1.0, 1.0
    pure = Weighting.of(maps).purity(5, wrap=False)
    assert pure.shape == (1, 8, 40)
    assert torch.allclose(pure[:, :, :18], torch.zeros(1, 8, 18), atol=1e-6)
    assert torch.allclose(pure[:, :, 22:], torch.ones(1, 8, 18))
    assert torch.allclose(pure[0, 0, 18:22], torch.arange(1, 5) / 5)  # the mean over 5 px
    assert float(Weighting.of(maps).purity(5, wrap=True)[0, 0, -1]) == pytest.approx(0.6)


@pytest.mark.parametrize(
    "maps",
    [
        torch.ones(1, 4, 4),
        torch.ones(4, 4),
        -torch.ones(2, 4, 4),
        torch.zeros(2, 4, 4),
        torch.full((2, 4, 4), torch.nan),
    ],
)
def test_maps_that_say_nothing_are_refused(maps: torch.Tensor) -> None:
    with pytest.raises(InputError):
        Weighting.of(maps)


def test_weights_are_made_to_sum_to_1() -> None:
    assert checked_weights((1, 1, 2), 3) == (0.25, 0.25, 0.5)
    for bad in ((1, 1), (1, -1, 1), (0, 0, 0), (1, float("nan"), 1)):
        with pytest.raises(InputError):
            checked_weights(bad, 3)


def test_what_is_slow_at_first_is_hurried() -> None:
    pace = Pace((0.0, 0.5, 1.0), (0.0, 0.2, 1.0))
    assert pace.weights(torch.tensor([0.0, 0.2, 0.6, 1.0])).tolist() == pytest.approx([0.0, 0.5, 0.75, 1.0])
    even = Weighting.even((0.8, 0.2), (3, 3)).paced(pace)
    assert even.palette[0] == pytest.approx((0.5, 0.5))
    ramp = torch.linspace(0, 1, 5).expand(2, -1)
    varied = Weighting.of(torch.stack([1 - ramp, ramp])).paced(pace)
    assert varied.values[1, 0].tolist() == pytest.approx([0, 0.53125, 0.6875, 0.84375, 1.0])


def test_where_textures_are_alike_the_pace_is_that_of_the_weights() -> None:
    windows, times = torch.rand(20, 9, 9, 4, generator=torch.Generator().manual_seed(0)), torch.linspace(0, 1, 7)
    matched = Mock(neighborhoods=range(20), windows=lambda some, weights: windows[some])
    assert torch.equal(Pace.of(matched, [Bands.of(torch.rand(3, 32, 32))] * 2).weights(times), times)
