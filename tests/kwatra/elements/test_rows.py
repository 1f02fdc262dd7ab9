import math

import pytest
import torch
from made import MADE
from scipy.ndimage import gaussian_filter
from skimage import data

from kwatra import Exemplar
from kwatra.elements import Rows, find_lattice, find_rows


def dashes(period, degrees, side=128, seed=0):
    """Dashes of many lengths on lines that fall by so many degrees to the right, a period apart."""
    generator = torch.Generator().manual_seed(seed)
    row, column = torch.meshgrid(torch.arange(float(side)), torch.arange(float(side)), indexing="ij")
    turn = math.radians(degrees)
    along = column * math.cos(turn) + row * math.sin(turn) + 2 * side
    across = row * math.cos(turn) - column * math.sin(turn) + 2 * side
    line = (across / period).long()
    ends = (4 + 24 * torch.rand(int(line.max()) + 1, 120, generator=generator)).cumsum(1)
    number = torch.searchsorted(ends[line], along[..., None])[..., 0]
    return (number % 2 * torch.sin(math.pi * across / period).square())[None]


@pytest.mark.parametrize(
    ("period", "degrees"), [(9, 0), (14.3, 0), (18.33, 0.5), (12, -31.4), (21, 88), (11.5, 90), (33.0, -60)]
)
def test_rows_are_found_at_any_angle(period, degrees):
    found = find_rows(Exemplar.of(dashes(period, degrees)))
    turn = math.radians(degrees)
    true = Rows(period * torch.tensor([math.cos(turn), -math.sin(turn)], dtype=torch.float64))
    assert found.shortest == pytest.approx(period, abs=0.02 + period / 200)
    assert float(true.rest(found.across).norm()) < 0.03 * period


def test_rows_of_letters_are_found_where_there_is_no_lattice():
    letters = Exemplar.of(MADE["letters"](128, 20, 0).image)
    assert find_lattice(letters) is None
    assert find_rows(letters).across.tolist() == pytest.approx([24, 0], abs=0.05)


@pytest.mark.parametrize(
    "picture",
    [
        torch.full((1, 60, 60), 0.3),
        torch.rand(3, 128, 128, generator=torch.Generator().manual_seed(0)),
        torch.from_numpy(gaussian_filter(torch.rand(128, 128, generator=torch.Generator().manual_seed(1)), 3))[None],
        torch.from_numpy(gaussian_filter(torch.rand(160, 160, generator=torch.Generator().manual_seed(2)), (1, 30)))[
            None
        ],
        torch.from_numpy(data.gravel()[:160, :160] / 255).float()[None],
        torch.from_numpy(data.grass()[:160, :160] / 255).float()[None],
        MADE["stones"](128, 16, 0).image,
        dashes(60, 0),
        torch.rand(1, 3, 5),
    ],
    ids=["flat", "noise", "blobs", "fibers", "gravel", "grass", "stones", "two rows", "tiny"],
)
def test_what_has_no_rows_has_none(picture):
    assert find_rows(Exemplar.of(picture)) is None


def test_what_is_left_of_an_offset_is_its_way_to_the_nearest_row():
    rows = Rows(torch.tensor([8.0, 6.0], dtype=torch.float64))
    offsets = torch.tensor([[8.0, 6.0], [-6.0, 8.0], [16.8, 12.6], [2.0, 11.0]]).T
    assert torch.allclose(rows.rest(offsets), torch.tensor([[0, 0], [0, 0], [0.8, 0.6], [-1.44, -1.08]]).T.double())
    assert rows.rest(offsets.view(2, 2, 2)).shape == (2, 2, 2)


def test_of_closed_rows_whole_periods_go_around_where_an_output_wraps():
    rows = Rows(18.0 * torch.tensor([math.cos(0.02), -math.sin(0.02)], dtype=torch.float64))
    closed = rows.closed((100, 90), (True, True))
    assert closed.across.tolist() == pytest.approx([100 / 6, 0])
    around = torch.tensor([[100.0, 0.0], [0.0, 90.0]])
    assert float(closed.rest(around).abs().max()) < 1e-9
    assert torch.allclose(rows.closed((100, 90), (False, False)).across, rows.across)
    beside = rows.closed((100, 90), (False, True))
    assert beside.across.tolist() == pytest.approx([18 / math.cos(0.02), 0])
    assert rows.closed((4, 4), (True, True)) is rows
