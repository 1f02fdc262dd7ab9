import math
from importlib import import_module

import pytest
import torch
from made import MADE
from scipy.ndimage import gaussian_filter

from kwatra import Exemplar
from kwatra.elements import element_size

size_module = import_module("kwatra.elements.size")
SIZES = (6, 12, 24, 32)
"""Up to a quarter of the exemplars' side."""


def size_of(image):
    return element_size(Exemplar.of(image))


def places(side):
    return torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")


def noise(seed, channels=3):
    return torch.rand(channels, 128, 128, generator=torch.Generator().manual_seed(seed))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "pitch", "side"), [("stones", 1, 128), ("coins", 1.25, 160), ("tiles", 1, 128), ("letters", 1.2, 128)]
)
def test_elements_are_as_large_as_they_were_made(name, pitch, side, size):
    found = size_of(MADE[name](side, size).image)
    assert pitch * size * 0.88 < found < pitch * size * 1.15


@pytest.mark.parametrize("name", ["stones", "coins", "tiles"])
def test_elements_of_a_large_image_are_measured_where_it_is_coarser(name, monkeypatch):
    image = MADE[name](160, 24).image
    whole = size_of(image)
    monkeypatch.setattr(size_module, "LOOKED_AT", 80**2)
    assert whole != size_of(image.clone()) == 2 * size_of(Exemplar.of(image).coarser((2, 2)).canvas)
    assert size_of(image.clone()) == pytest.approx(whole, rel=0.05)
    monkeypatch.setattr(size_module, "LOOKED_AT", 1000)
    assert size_of(image[:, :12].clone()) > 0  # a strip, which is not made coarser


@pytest.mark.parametrize("size", SIZES)
def test_cells_that_alternate_are_elements(size):
    y, x = places(128)
    assert size_of(((y // size + x // size) % 2).float()[None]) == pytest.approx(size, rel=0.1)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("angle", [0, 30, 90])
def test_stripes_are_elements_at_any_angle(size, angle):
    y, x = places(128)
    across = x * math.cos(math.radians(angle)) + y * math.sin(math.radians(angle))
    assert size_of(((across / size).floor() % 2)[None]) == pytest.approx(size, rel=0.25)


@pytest.mark.parametrize("size", SIZES)
def test_cells_without_gaps_are_told_apart_by_their_edges(size):
    y, x = places(128)
    assert size_of(noise(0)[:, y // size, x // size]) == pytest.approx(size, rel=0.12)


def test_the_brightness_of_an_element_does_not_matter():
    stones = MADE["stones"](128, 24).image
    brightness = torch.rand(1, 1, 1, generator=torch.Generator().manual_seed(0)) * stones.mean(0, keepdim=True)
    assert size_of(stones - 0.9 * brightness) == pytest.approx(24, rel=0.12)


def test_blobs_of_noise_grow_with_it():
    found = [size_of(torch.from_numpy(gaussian_filter(noise(1).numpy(), (0, s, s), mode="wrap"))) for s in (1, 2, 4)]
    assert found[0] < found[1] < found[2]
    for blob, size in zip((1, 2, 4), found, strict=True):
        assert 4 * blob < size < 8 * blob  # twice a blob's width at half its height is 4.7 of its deviations


def test_white_noise_and_one_color_have_the_smallest_elements():
    assert size_of(noise(2)) == pytest.approx(2, abs=0.5)
    assert size_of(torch.full((3, 32, 32), 0.4)) == 2.0


def test_the_content_of_holes_does_not_matter():
    stones = MADE["stones"](128, 24).image
    mask = torch.ones(128, 128, dtype=torch.bool)
    mask[40:70, 50:90] = False
    y, x = places(128)
    painted = torch.where(mask, stones, 50 * ((y // 5 + x // 5) % 2).float())
    there, nothing = (element_size(Exemplar.of(t, masks=[mask])) for t in (painted, torch.where(mask, stones, 0.0)))
    assert there == nothing == pytest.approx(24, rel=0.12)
    assert size_of(painted) != pytest.approx(24, rel=0.12)


def test_several_pictures_count_together_and_copies_of_them_do_not():
    pictures = [MADE["stones"](96, 16, seed).image for seed in (0, 1)]
    assert element_size(Exemplar.of(pictures)) == pytest.approx(16, rel=0.12)
    assert element_size(Exemplar.of(pictures, rotate=(45.0,), scale=(2.0,))) == element_size(Exemplar.of(pictures))


def test_a_video_is_looked_at_frame_by_frame():
    frames = torch.stack([MADE["stones"](96, 16, seed).image for seed in (0, 1)], 1)
    assert size_of(frames) == pytest.approx(16, rel=0.12)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (4, 4), (7, 40)])
def test_the_smallest_pictures_have_a_size(shape):
    image = torch.rand(3, *shape, generator=torch.Generator().manual_seed(0))
    assert 2 <= size_of(image) <= 20
