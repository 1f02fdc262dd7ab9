import numpy as np
import pytest
import torch
from made import MADE
from scipy import ndimage
from skimage import data

from kwatra import Exemplar
from kwatra.elements import find_outlines

COLORS = torch.tensor([[0.8, 0.2, 0.2], [0.2, 0.6, 0.3], [0.2, 0.3, 0.8], [0.9, 0.8, 0.3]]).T


def board(soft: float = 0.0) -> torch.Tensor:
    """Cells of 16x16 pixels in four colors, the first column of each mixed of so much of what lies before it."""
    rows = torch.arange(96) // 16
    number = (rows[:, None] + 2 * rows + rows[:, None] // 2) % 4
    image = COLORS[:, number]
    before = image.roll(1, 2)
    mixed = torch.arange(96) % 16 == 0
    mixed[0] = False
    return torch.where(mixed, (1 - soft) * image + soft * before, image)


def ends(parts: np.ndarray) -> np.ndarray:
    """Where a part meets another, left and right of each other (H, W - 1)."""
    return parts[:, 1:] != parts[:, :-1]


@pytest.mark.parametrize("name", ["patches", "confetti"])
@pytest.mark.parametrize("size", [20, 32])
def test_parts_are_elements_that_touch(name, size):
    """Of outlines between colors that differ most are found, within two pixels, and few others."""
    made = MADE[name](160, size, 1)
    found = find_outlines(Exemplar.of(made.image))
    assert found.hides > 0.5
    numbers = made.numbers.numpy()
    area = np.maximum(np.bincount(numbers.ravel()), 1)
    mean = np.stack([np.bincount(numbers.ravel(), channel.ravel()) / area for channel in made.image.numpy()])
    apart = np.linalg.norm(mean[:, numbers[:, 1:]] - mean[:, numbers[:, :-1]], axis=0)
    truth, here = ends(numbers), ends(found.parts)
    clear = truth & (apart > 0.3)
    assert (ndimage.distance_transform_edt(~here)[clear] <= 2).mean() > 0.8
    assert (ndimage.distance_transform_edt(~truth)[here] <= 2).mean() > 0.9


def test_cells_are_parts_each_with_its_outline():
    found = find_outlines(Exemplar.of(board()))
    assert found.hides > 0.9
    cells = found.parts.reshape(6, 16, 6, 16).transpose(0, 2, 1, 3).reshape(36, 16, 16)
    assert len(np.unique(cells[:, 8, 8])) == 36
    corners = np.add.outer(*[np.minimum(np.arange(16), np.arange(16)[::-1])] * 2) == 0  # at which four meet
    assert (cells == cells[:, 8:9, 8:9])[:, ~corners].all()
    assert (cells > 0).all()
    at = np.arange(96)
    beside = (np.minimum(at % 16, 15 - at % 16) == 0) & (at > 0) & (at < 95)  # the picture's border is no outline
    assert (found.depth[beside[:, None] ^ beside] == 0).all()
    assert (found.depth[~beside[:, None] & ~beside] > 0).all()


def test_what_is_mixed_of_two_parts_is_of_none():
    parts = find_outlines(Exemplar.of(board(0.5))).parts
    mixed = np.arange(96)[16::16]
    assert (parts[:, mixed] == 0).mean() > 0.9
    assert (np.delete(parts, mixed, 1) > 0).mean() > 0.99
    assert (find_outlines(Exemplar.of(board(0.1))).parts > 0).mean() > 0.99


def test_what_noise_mixes_stays_of_its_part(monkeypatch):
    noise = 0.03 * torch.randn(3, 96, 96, generator=torch.Generator().manual_seed(0))
    noisy = (board() + noise).clamp(0, 1)
    assert (find_outlines(Exemplar.of(noisy)).parts > 0).mean() > 0.99
    monkeypatch.setattr("kwatra.elements.outlines.NOISE", 0.0)
    assert (find_outlines(Exemplar.of(noisy.clone())).parts > 0).mean() < 0.98


@pytest.mark.parametrize("name", ["brick", "gravel", "grass"])
def test_photographs_have_no_outlines(name):
    image = torch.from_numpy(getattr(data, name)()[:192, :192] / 255).float()[None]
    assert find_outlines(Exemplar.of(image)) is None


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("smooth", [0.0, 2.0, 6.0])
def test_noise_has_no_outlines(channels, smooth):
    rng = np.random.default_rng(0)
    noise = ndimage.gaussian_filter(rng.random((channels, 128, 128)), (0, smooth, smooth))
    assert find_outlines(Exemplar.of(torch.from_numpy(noise / noise.max()).float())) is None


def test_bricks_of_one_color_are_apart_by_ground_alone():
    assert find_outlines(Exemplar.of(MADE["bricks"](128, 32, 0).image)) is None


@pytest.mark.parametrize("shape", [(2, 2), (1, 40), (3, 9)])
def test_tiny_and_blank_pictures_have_none(shape):
    for image in (torch.rand(3, *shape, generator=torch.Generator().manual_seed(0)), torch.full((3, *shape), 0.5)):
        assert find_outlines(Exemplar.of(image)) is None


def test_holes_are_of_no_part():
    mask = torch.ones(96, 96, dtype=torch.bool)
    mask[30:50, 40:70] = False
    found = find_outlines(Exemplar.of(board(), masks=[mask]))
    assert (found.parts[~mask.numpy()] == 0).all()
    assert (found.parts[mask.numpy()] > 0).mean() > 0.95
