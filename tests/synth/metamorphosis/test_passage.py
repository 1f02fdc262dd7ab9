"""The passage from A to B: its ends, a known motion, pictures that tile."""

from collections.abc import Callable

import pytest
import torch
from pictures import cloud

from kwatra.base import InputError
from synth.metamorphosis.patches.feature_maps import find_features
from synth.metamorphosis.patches.model import Making
from synth.metamorphosis.patches.passage import Passage
from synth.metamorphosis.patches.weighting import Weighting
from synth.metamorphosis.velocity import Search


def passage(a: torch.Tensor, b: torch.Tensor, wrap: bool = False) -> Passage:
    return Passage.of((a, b), find_features((a, b)).maps, 17, Making(), Search(), wrap, lambda what, part: None)


def between(time: float) -> Weighting:
    return Weighting.even((1 - time, time), (48, 48))


@pytest.fixture(scope="module")
def clouds() -> Callable[[float], torch.Tensor]:
    return lambda part: cloud(48, 4 * part, part)


@pytest.fixture(scope="module")
def way(clouds: Callable[[float], torch.Tensor]) -> Passage:
    """From the first clouds to the last."""
    return passage(clouds(0), clouds(1))


def test_the_ends_are_the_pictures(clouds: Callable[[float], torch.Tensor], way: Passage) -> None:
    for time in (0.0, 1.0):
        assert float((way.at(between(time))[:-1] - clouds(time)).abs().max()) < 1e-4


def test_halfway_a_picture_that_moves_and_changes_color_has_done_half_of_both(
    clouds: Callable[[float], torch.Tensor], way: Passage
) -> None:
    shown = way.at(between(0.5))[:-1]
    inside = (slice(None), slice(8, -8), slice(8, -8))
    apart = float((shown - clouds(0.5))[inside].abs().mean())
    still = float((torch.lerp(clouds(0), clouds(1), 0.5) - clouds(0.5))[inside].abs().mean())
    assert apart < 0.2 * still
    assert float((shown[:, ::47, ::47] - clouds(0.5)[:, ::47, ::47]).abs().max()) < 0.2  # windows may leave a corner


def test_pictures_that_tile_pass_through_their_borders(clouds: Callable[[float], torch.Tensor]) -> None:
    y, x = torch.meshgrid(torch.arange(48.0), torch.arange(48.0), indexing="ij")
    turn = 2 * torch.pi / 48
    a, half, b = (
        (0.5 + 0.2 * torch.sin(turn * 4 * (x - shift)) + 0.2 * torch.cos(turn * (3 * y + x - shift)))[None]
        for shift in (0.0, 1.5, 3.0)
    )
    shown = passage(a, b, wrap=True).at(between(0.5))[:-1]
    assert float((shown - half).abs().max()) < 0.3 * float((torch.lerp(a, b, 0.5) - half).abs().max())


def test_pictures_that_tile_may_be_smaller_than_windows_reach() -> None:
    pictures = [cloud(48, 4 * part, part)[:, 10:30] for part in (0.0, 1.0)]  # of windows of 17 px the margin is 34
    way = passage(*pictures, wrap=True)
    for time, picture in enumerate(pictures):
        assert float((way.at(Weighting.even((1.0 - time, float(time)), (20, 48)))[:-1] - picture).abs().max()) < 1e-4


def test_where_weights_differ_each_place_shows_its_own(way: Passage) -> None:
    share = torch.zeros(48, 48)
    share[:, 16:32], share[:, 32:] = torch.linspace(0, 1, 16), 1
    shown = way.at(Weighting.of(torch.stack([1 - share, share])))
    assert torch.allclose(shown[..., :6], way.at(between(0.0))[..., :6], atol=1e-5)
    assert torch.allclose(shown[..., -6:], way.at(between(1.0))[..., -6:], atol=1e-5)
    assert float((shown - way.at(between(0.5)))[:-1, 8:40, 24].abs().mean()) < 0.02


def test_of_three_pictures_each_is_itself_and_the_third_does_not_show_between_two(
    clouds: Callable[[float], torch.Tensor],
) -> None:
    images = (clouds(0), clouds(1), clouds(0).flip(1))
    way = Passage.of(images, find_features(images).maps, 17, Making(), Search(), False, lambda what, part: None)
    for number, image in enumerate(images):
        weights = tuple(float(number == own) for own in range(3))
        assert float((way.at(Weighting.even(weights, (48, 48)))[:-1] - image).abs().max()) < 1e-4
    shown = way.at(Weighting.even((0.5, 0.5, 0.0), (48, 48)))[:-1, 8:-8, 8:-8]
    still = torch.lerp(clouds(0), clouds(1), 0.5)[:, 8:-8, 8:-8]
    assert float((shown - clouds(0.5)[:, 8:-8, 8:-8]).abs().mean()) < 0.4 * float(
        (still - clouds(0.5)[:, 8:-8, 8:-8]).abs().mean()
    )


def test_a_velocity_at_half_the_resolution_leads_there_too(clouds: Callable[[float], torch.Tensor]) -> None:
    images = (clouds(0), clouds(1))
    way = Passage.of(images, find_features(images).maps, 17, Making(), Search(), False, lambda what, part: None, 2)
    shown = way.at(between(0.5))[:-1, 8:-8, 8:-8]
    still = torch.lerp(*images, 0.5)[:, 8:-8, 8:-8]
    half = clouds(0.5)[:, 8:-8, 8:-8]
    assert float((shown - half).abs().mean()) < 0.3 * float((still - half).abs().mean())


def test_a_picture_and_itself_are_that_picture_at_any_time(clouds: Callable[[float], torch.Tensor]) -> None:
    assert float((passage(clouds(0), clouds(0)).at(between(0.4))[:-1] - clouds(0)).abs().max()) < 1e-4


def waves(side: int, scale: float) -> torch.Tensor:
    """Waves of several directions about the middle of an image, `scale` times as long."""
    line = (torch.arange(side) - (side - 1) / 2) / scale
    y, x = torch.meshgrid(line, line, indexing="ij")
    return (0.5 + 0.2 * torch.sin(0.7 * x + 0.2 * y) + 0.2 * torch.cos(0.5 * y - 0.3 * x + 1))[None]


def test_what_differs_in_scale_alone_grows_from_frame_to_frame() -> None:
    units = (0.8, 1.25)
    pictures = (waves(48, units[0]), waves(76, units[1]))
    maps = find_features(pictures).maps
    way = Passage.of(pictures, maps, 17, Making(), Search(), False, lambda what, part: None, units=units)
    ends = waves(48, units[0]), waves(48, units[1])
    for time, end in zip((0.0, 1.0), ends, strict=True):
        assert float((way.at(between(time))[:-1] - end).abs().max()) < 1e-4
    for time in (0.25, 0.5, 0.75):
        expected = waves(48, units[0] * (units[1] / units[0]) ** time)
        apart = (way.at(between(time))[:-1] - expected)[:, 4:-4, 4:-4].abs().mean()
        assert float(apart) < 0.15 * float((torch.lerp(*ends, time) - expected)[:, 4:-4, 4:-4].abs().mean())
    with pytest.raises(InputError, match="several scales are given several weights"):
        way.at(Weighting.of(torch.stack([waves(48, 1)[0], 1 - waves(48, 1)[0]])))
