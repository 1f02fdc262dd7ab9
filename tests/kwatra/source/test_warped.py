"""What an image shows between its pixels, and its detail where it is read apart."""

import torch
from torch import Tensor

from kwatra.source.warped import read_between, read_warped


def seeded(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def stretched(height: int, width: int, times: float) -> Tensor:
    """Places (2, height, width) of what is so many times as long as it was."""
    row, column = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return torch.stack([row / times, column.double()]).double()


def test_between_pixels_colors_are_cubic_splines_within_those_around_and_on_them_exact() -> None:
    image = torch.rand(2, 6, 9, generator=seeded(3))
    places = torch.tensor([[[2.0, 2.25, 5.4, -0.3]], [[7.0, 3.5, 8.3, 4.0]]], dtype=torch.float64)
    read = read_between(image, places)[:, 0]
    assert torch.equal(read[:, 0], image[:, 2, 7])
    around = image[:, 2:4, 3:5].flatten(1)
    assert ((read[:, 1] >= around.amin(1)) & (read[:, 1] <= around.amax(1))).all()
    assert torch.equal(read[:, 2], image[:, 5, 8])  # beyond the border what is on it
    assert torch.equal(read[:, 3], image[:, 0, 4])


def test_a_smooth_wave_is_read_between_pixels_as_it_is() -> None:
    row, column = torch.meshgrid(torch.arange(40.0), torch.arange(48.0), indexing="ij")
    wave = 0.5 + 0.3 * torch.sin(row / 2 + column / 3)
    places = torch.stack([row, column])[:, 8:-8, 8:-8].double() + torch.tensor([0.3, 0.6]).view(2, 1, 1)
    read = read_between(wave[None], places)[0]
    expected = 0.5 + 0.3 * torch.sin(places[0] / 2 + places[1] / 3).float()
    off = (read - expected).abs()
    assert float(off.mean()) < 1e-3  # bilinear .007; at crests four pixels around hold it back
    assert float(off.max()) < 0.02


def test_places_are_read_each_by_itself() -> None:
    image = torch.rand(3, 12, 14, generator=seeded(4))
    places = 11 * torch.rand(2, 5, 7, generator=seeded(5), dtype=torch.float64)
    read = read_between(image, places)
    assert torch.equal(read.mT, read_between(image, places.mT))
    assert torch.allclose(read.mT.flip(0), read_between(image.flip(0), places.mT))


def test_detail_that_is_read_apart_is_not_stretched_and_what_is_smooth_is() -> None:
    row, _ = torch.meshgrid(torch.arange(64.0), torch.arange(64.0), indexing="ij")
    smooth, grain = 0.5 + 0.004 * (row - 32), 0.1 * torch.randn(64, 64, generator=seeded(6))
    places = stretched(60, 60, 2.0)
    detail = torch.stack(torch.meshgrid(torch.arange(60), torch.arange(60), indexing="ij"))
    pixels = (smooth + grain)[None]
    warped = read_between(pixels, places)[0]
    apart = read_warped(pixels, places, detail, torch.ones(60, 60))[0]
    down, across = (lambda image, axis=axis: float(image.diff(dim=axis).std()) for axis in (0, 1))
    assert down(warped) < 0.75 * across(warped)
    assert 0.95 < down(apart) / across(apart) < 1.05
    assert down(apart) > 0.85 * down(pixels[0])
    slope = (apart[40:, :].mean() - apart[:20, :].mean()) / 40
    assert abs(float(slope) - 0.002) < 3e-4


def test_a_share_of_detail_is_between_all_of_it_and_none() -> None:
    pixels, places = torch.rand(3, 20, 20, generator=seeded(7)), stretched(18, 18, 1.3)
    detail, share = places.round().long().flip(0), torch.rand(18, 18, generator=seeded(8))
    share[:, :4] = 0.0
    none = read_warped(pixels, places, detail, torch.zeros(18, 18))
    every = read_warped(pixels, places, detail, torch.ones(18, 18))
    some = read_warped(pixels, places, detail, share)
    assert torch.equal(none, read_between(pixels, places))
    assert torch.equal(some[:, :, :4], none[:, :, :4])
    assert ((some >= torch.minimum(none, every) - 1e-6) & (some <= torch.maximum(none, every) + 1e-6)).all()
    assert pixels.min() <= every.min()
    assert every.max() <= pixels.max()


def test_detail_that_is_read_where_all_is_changes_nothing() -> None:
    pixels = torch.rand(2, 20, 24, generator=seeded(9))
    detail = torch.stack(torch.meshgrid(torch.arange(3, 17), torch.arange(2, 20), indexing="ij"))
    read = read_warped(pixels, detail.double(), detail, torch.ones(14, 18))
    torch.testing.assert_close(read, pixels[:, 3:17, 2:20])
