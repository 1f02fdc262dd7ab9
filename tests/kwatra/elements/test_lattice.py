import math

import numpy as np
import pytest
import torch
from made import MADE
from scipy.ndimage import gaussian_filter
from skimage import data

from kwatra import Exemplar
from kwatra.elements import Lattice, find_lattice
from kwatra.elements.lattice import reduced


def places(side):
    return torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")


def dots(first, second, side=128, jitter=0.0, seed=0):
    """Dots of two colors, at points of a lattice, moved at random by `jitter` pixels."""
    generator = torch.Generator().manual_seed(seed)
    steps = torch.cartesian_prod(*[torch.arange(-40, 41)] * 2).double()
    points = steps @ torch.tensor([first, second], dtype=torch.float64) + torch.tensor([3.3, 1.7])
    points += jitter * torch.randn(points.shape, generator=generator, dtype=torch.float64)
    width = min(math.hypot(*first), math.hypot(*second)) / 5
    points = points[((points > -3 * width) & (points < side + 3 * width)).all(1)]
    y, x = places(side)
    distance = (y[..., None] - points[:, 0]).square() + (x[..., None] - points[:, 1]).square()
    dot = torch.exp(-0.5 * distance / width**2).sum(-1)
    return torch.stack([dot, 0.5 * dot, 1 - dot]).float()


def noise(width, seed):
    pixels = torch.rand(3, 128, 128, generator=torch.Generator().manual_seed(seed)).numpy()
    return torch.from_numpy(gaussian_filter(pixels, (0, width, width)))


def lattice_of(image):
    return find_lattice(Exemplar.of(image))


def distance(found, first, second):
    """By how many pixels the vectors that should be there miss the lattice found; also the other way round."""
    true = Lattice(torch.tensor([first, second], dtype=torch.float64), 1.0)
    there = found.rest(true.vectors.T).norm(dim=0).max()
    return max(float(there), float(true.rest(found.vectors.T).norm(dim=0).max()))


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((16, 0), (0, 16)),
        ((12.4, 5.1), (-5.1, 12.4)),
        ((20.3, 3.7), (8.2, 17.9)),
        ((7.3, 1), (2, 9.1)),
        ((12, 0), (6, 10.4)),
        ((43.3, 4), (-6, 41)),
        ((60, 10), (-12, 65)),
    ],
)
@pytest.mark.parametrize("jitter", [0, 0.03])
def test_a_lattice_is_found_at_any_angle_to_within_half_a_pixel(first, second, jitter):
    amount = jitter * math.hypot(*first)
    found = lattice_of(dots(first, second, jitter=amount))
    assert found is not None
    assert distance(found, first, second) < 0.2 + amount
    assert found.regularity > 0.9


@pytest.mark.parametrize("size", [6, 12, 24, 32])
def test_a_checkerboard_repeats_along_its_diagonals(size):
    y, x = places(128)
    found = lattice_of(((y // size + x // size) % 2).float()[None])
    assert distance(found, (size, size), (size, -size)) < 1e-3
    assert found.regularity == pytest.approx(1)


def test_two_and_a_half_cells_of_a_checkerboard_are_enough():
    y, x = places(85)
    assert distance(lattice_of((((y + 7) // 32 + (x + 1) // 32) % 2).float()[None]), (32, 32), (32, -32)) < 1e-3


@pytest.mark.parametrize("period", [(60, 53), (75, 68), (85, 78)])
def test_one_and_a_half_periods_are_enough(period):
    cell = noise(2, 0)[:, : period[0], : period[1]]
    y, x = places(128)
    assert distance(lattice_of(cell[:, y % period[0], x % period[1]]), (period[0], 0), (0, period[1])) < 1e-3


def test_bricks_in_running_bond_repeat_by_half_a_brick():
    y, x = places(128)
    course = y // 12
    wall = ((y % 12 >= 2) & ((x + 15 * (course % 2)) % 30 >= 2)).float()
    grain = 0.05 * torch.randn(128, 128, generator=torch.Generator().manual_seed(0))
    assert distance(lattice_of((wall + grain)[None]), (12, 15), (24, 0)) < 0.2


def test_a_tartan_repeats_by_its_sett():
    y, x = places(128)
    stripes = torch.tensor([0.1, 0.1, 0.8, 0.1, 0.4, 0.4, 1.0, 0.4]).repeat_interleave(5)
    threads = torch.stack([stripes, stripes.flip(0), stripes.roll(7)])
    assert distance(lattice_of((threads[:, y % 40] + threads[:, x % 40]) / 2), (40, 0), (0, 40)) < 1e-3


def test_tiles_of_many_colors_repeat_by_their_joints():
    assert distance(lattice_of(MADE["tiles"](128, 20).image), (20, 0), (0, 20)) < 0.5


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("width", [0.01, 1, 3, 8])
def test_noise_has_no_lattice(width, seed):
    assert lattice_of(noise(width, seed)) is None


@pytest.mark.parametrize("name", ["stones", "letters"])
@pytest.mark.parametrize("size", [6, 12, 24, 32])
def test_scattered_stones_and_lines_of_letters_have_no_lattice(name, size):
    assert lattice_of(MADE[name](128, size).image) is None


@pytest.mark.parametrize("image", [data.grass(), data.gravel()])
def test_grass_and_gravel_have_no_lattice(image):
    assert lattice_of(torch.from_numpy(np.ascontiguousarray(image[None, ::2, ::2])).float() / 255) is None


def test_one_color_has_no_lattice():
    assert lattice_of(torch.full((3, 64, 64), 0.5)) is None


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (4, 4)])
def test_the_smallest_pictures_have_no_lattice(shape):
    assert lattice_of(torch.rand(3, *shape, generator=torch.Generator().manual_seed(0))) is None


def test_the_content_of_holes_does_not_matter():
    image, mask = dots((20.3, 3.7), (8.2, 17.9)), torch.ones(128, 128, dtype=torch.bool)
    mask[40:80, 50:90] = False
    hidden = torch.where(mask, image, 20 * noise(1, 0))
    found = find_lattice(Exemplar.of(hidden, masks=[mask]))
    assert distance(found, (20.3, 3.7), (8.2, 17.9)) < 0.2
    fooled = lattice_of(hidden)
    assert fooled is None or distance(fooled, (20.3, 3.7), (8.2, 17.9)) > 2


def test_the_rest_of_an_offset_is_its_distance_to_the_nearest_point():
    lattice = Lattice(torch.tensor([[10.0, 2.0], [-3.0, 12.0]], dtype=torch.float64), 1.0)
    offsets = 60 * torch.rand(2, 200, generator=torch.Generator().manual_seed(0), dtype=torch.float64) - 30
    points = torch.cartesian_prod(*[torch.arange(-8, 9)] * 2).double() @ lattice.vectors
    nearest = (offsets.T[:, None] - points).norm(dim=2).amin(1)
    assert torch.allclose(lattice.rest(offsets).norm(dim=0), nearest)


def test_reduced_vectors_are_the_shortest_of_each_lattice_and_point_down_or_right():
    pairs = torch.randint(-9, 10, (60, 2, 2), generator=torch.Generator().manual_seed(0)).double()
    pairs = pairs[torch.linalg.det(pairs).abs() > 0.5]
    steps = torch.cartesian_prod(*[torch.arange(-30, 31)] * 2).double()
    for pair, found in zip(pairs, reduced(pairs), strict=True):
        points = steps @ pair
        lengths = points[(steps != 0).any(1)].norm(dim=1)
        assert float(found[0].norm()) == pytest.approx(float(lengths.min()))
        assert float(torch.linalg.det(found).abs()) == pytest.approx(float(torch.linalg.det(pair).abs()))
        across = (points[:, 0] * found[0, 1] - points[:, 1] * found[0, 0]).abs() > 0.5
        assert float(found[1].norm()) == pytest.approx(float(points[across].norm(dim=1).min()))
        assert all(vector >= [0, 0] for vector in found.tolist())
        torch.testing.assert_close(reduced(pair), found, rtol=0, atol=0)


def test_vectors_whose_points_share_peaks_stay_apart():
    """Of a picture of few pixels they were fitted onto one line, which no reduction ends for."""
    rows = ["11111221111111", *["22222332222222"] * 3, *["11111111111111"] * 4] * 9
    image = torch.tensor([[int(tone) for tone in row] for row in rows[:68]])[None] / 3
    found = find_lattice(Exemplar.of(image))
    assert found is None or float(torch.linalg.det(found.vectors).abs()) > 10
