"""The scale that textures share."""

import pytest
import torch

from synth.metamorphosis.patches.feature_maps import find_features
from synth.metamorphosis.patches.scales import LARGEST_RATIO, common_units


def tiles(period: int, seed: int, size: int = 96) -> torch.Tensor:
    """Tiles of several tones with dark joints, (1, size, size)."""
    line = torch.arange(size)
    joint = (line % period < 2)[:, None] | (line % period < 2)[None]
    tones = 0.5 + 0.4 * torch.rand(1, 20, 20, generator=torch.Generator().manual_seed(seed))
    return torch.where(joint, 0.1, tones[:, (line // period)[:, None], (line // period)[None]])


def units(*images: torch.Tensor) -> tuple[float, ...]:
    return common_units(images, find_features(images).maps)


def test_elements_of_other_size_are_brought_to_one() -> None:
    one, other = units(tiles(8, 0), tiles(12, 1))
    assert other / one == pytest.approx(1.5, rel=0.15)
    assert one * other == pytest.approx(1)
    first, second, third = units(tiles(8, 0), tiles(12, 1), tiles(8, 2))
    assert (first, second / first) == pytest.approx((third, other / one), rel=0.05)
    one, other = units(tiles(7, 0), tiles(15, 1))
    assert other / one == pytest.approx(LARGEST_RATIO)


def test_elements_of_one_size_stay_as_they_are() -> None:
    assert units(tiles(10, 0), tiles(10, 1)) == (1.0, 1.0)
    assert units(tiles(6, 0, 18), tiles(9, 1, 18)) == (1.0, 1.0)  # no window would be left


def test_sizes_that_do_not_make_textures_more_alike_are_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    images = tiles(10, 0), tiles(10, 1)
    measured = iter((10.0, 16.0))
    monkeypatch.setattr("synth.metamorphosis.patches.scales.element_size", lambda exemplar: next(measured))
    assert units(*images) == (1.0, 1.0)
