import math

import pytest
import torch

from kwatra import Exemplar
from kwatra.elements import Slant, find_slant


def lines(degrees, noise=0.02):
    """Lines (1, 96, 96) that go so many degrees to the right of straight down."""
    row, column = torch.meshgrid(torch.arange(96.0), torch.arange(96.0), indexing="ij")
    across = column * math.cos(math.radians(degrees)) - row * math.sin(math.radians(degrees))
    grain = torch.randn(96, 96, generator=torch.Generator().manual_seed(0))
    return (0.5 + 0.3 * torch.cos(across * 0.8) + noise * grain)[None]


@pytest.mark.parametrize(
    ("degrees", "along", "aside", "on"),
    [(0, 0, 0, 1), (15, 0, 1, 4), (-27, 0, -1, 2), (44, 0, 1, 1), (57, 1, 2, 3), (-72, 1, -1, 3), (90, 1, 0, 1)],
)
def test_how_lines_run_is_found(degrees, along, aside, on):
    found = find_slant(Exemplar.of(lines(degrees)))
    assert (found.along, found.aside, found.on) == (along, aside, on)
    assert found.anisotropy > 4


def test_anisotropy_is_that_of_slopes():
    """Noise of which a direction is drawn out changes less along it; one color not at all."""
    noise = torch.randn(1, 128, 128, generator=torch.Generator().manual_seed(1))
    assert find_slant(Exemplar.of(noise)).anisotropy == pytest.approx(1, abs=0.1)
    assert find_slant(Exemplar.of(torch.full((3, 40, 40), 0.25))).anisotropy == 1
    assert find_slant(Exemplar.of(lines(0, noise=0))).anisotropy > 1e3
    row, column = torch.meshgrid(torch.arange(128.0), torch.arange(128.0), indexing="ij")
    both = torch.cos(0.3 * (row + column)) + 0.25 * torch.cos(0.3 * (row - column))
    assert find_slant(Exemplar.of(both[None])).anisotropy == pytest.approx(4, rel=0.05)


def test_a_hole_is_not_looked_at():
    image, mask = lines(30), torch.ones(96, 96, dtype=torch.bool)
    image[:, 30:60, 30:60], mask[30:60, 30:60] = lines(-60)[:, 30:60, 30:60], False
    found = find_slant(Exemplar.of(image, masks=[mask]))
    assert (found.along, found.aside > 0) == (0, True)
    assert found.anisotropy > 4


@pytest.mark.parametrize(("aside", "on"), [(1, 3), (-2, 3), (1, 1), (0, 1)])
def test_lines_go_aside_by_whole_pixels_and_as_far_in_each_step(aside, on):
    moved = Slant(0, aside, on, 9.0).moved(20)
    assert moved.tolist() == [math.floor(n * aside / on) for n in range(20)]
    assert (moved[on:] - moved[:-on] == aside).all()
