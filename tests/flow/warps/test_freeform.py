"""Free-form warps: they meet their points, do not fold, and agree with thin plates where those are right."""

import numpy as np
import pytest
import torch
from scipy.interpolate import RBFInterpolator
from torch import Tensor

from flow.warps import free_form, pixel_coordinates, warp
from flow.warps.freeform import _fitted
from kwatra import InputError

SIZE = (64, 96)


def random(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def jittered(pitch: int, seed: int = 0) -> Tensor:
    """Points about a lattice, (N, 2), at least half a pitch apart."""
    x, y = torch.meshgrid(torch.arange(8, 92, pitch), torch.arange(8, 58, pitch), indexing="xy")
    points = torch.stack([x, y], -1).flatten(0, 1).float()
    return points + (torch.rand(points.shape, generator=random(seed)) - 0.5) * pitch / 2


def smallest_jacobian(displacement: Tensor) -> float:
    places = pixel_coordinates(displacement.shape[1:]) + displacement
    across = places[:, :-1, 1:] - places[:, :-1, :-1]
    down = places[:, 1:, :-1] - places[:, :-1, :-1]
    return float((across[0] * down[1] - across[1] * down[0]).min())


@pytest.mark.parametrize("seed", range(3))
def test_points_are_met_within_half_a_pixel(seed: int) -> None:
    points = jittered(12, seed)
    ways = (torch.rand(points.shape, generator=random(seed + 9)) * 2 - 1) * 3
    met = warp(free_form(points, ways, SIZE), points.T, "bilinear").T
    assert float((met - ways).norm(dim=1).max()) < 0.6  # half a pixel, and what is lost between pixels


def test_a_finer_lattice_is_not_used_than_asked_for() -> None:
    points = torch.tensor([[40.0, 30.0], [42.0, 30.0]])
    ways = torch.tensor([[1.5, 0.0], [-1.5, 0.0]])
    fine, coarse = (free_form(points, ways, SIZE, finest=finest) for finest in (1.0, 32.0))
    assert float(fine.abs().max()) > 0.9
    assert float(coarse.abs().max()) < 0.2


@pytest.mark.parametrize("wrap", [False, True])
def test_nothing_folds_below_the_bound(wrap: bool) -> None:
    points = jittered(12, 1)
    signs = torch.randint(0, 2, points.shape, generator=random(2)) * 2 - 1
    displacement = free_form(points, 0.48 * 6 * signs.float(), SIZE, wrap=wrap)
    assert smallest_jacobian(displacement) > 0


def test_points_that_share_no_control_point_are_met_by_one_lattice() -> None:
    points, ways = torch.tensor([[12.0, 14.0], [83.0, 79.0]]), torch.tensor([[1.5, -2.0], [-1.5, 2.0]])
    lattice = _fitted(points.double(), ways.double(), torch.tensor([96.0, 96.0]).double(), (8, 8), False)
    torch.testing.assert_close(lattice(points.double()), ways.double())


def test_lattices_fitted_once_do_not_swirl_where_points_contradict_each_other() -> None:
    """Rows 3 px apart ask for opposite ways of 5 px, less than a cell of 6 px can tell apart."""
    x, y = torch.meshgrid(torch.arange(2.0, 96, 4), torch.arange(8.0, 64, 16), indexing="xy")
    above = torch.stack([x, y], -1)
    way = torch.where((y // 16) % 2 == 1, 5.0, -5.0)[..., None] * torch.tensor([1.0, 0.0])
    points, ways = torch.cat([above, above + torch.tensor([0.0, 3.0])]), torch.cat([way, -way])
    once, often = (
        free_form(points.flatten(0, 1), ways.flatten(0, 1), SIZE, finest=5.0, repeats=repeats) for repeats in (1, 8)
    )
    assert float(once.norm(dim=0).max()) < 5 < float(often.norm(dim=0).max())


def test_points_that_ask_for_a_fold_get_none() -> None:
    points = torch.tensor([[40.0, 30.0], [50.0, 30.0]])
    crossing = torch.tensor([[20.0, 0.0], [-20.0, 0.0]])
    assert smallest_jacobian(free_form(points, crossing, SIZE, finest=4.0)) > -1e-4


def test_smooth_displacements_agree_with_thin_plates() -> None:
    points = torch.rand(150, 2, generator=random(3)) * torch.tensor([95.0, 63.0])

    def smooth(at: Tensor) -> Tensor:
        return torch.stack([4 * (at[:, 0] / 40).sin() + 2 * (at[:, 1] / 50).cos(), 3 * (at.sum(1) / 50).cos()], 1)

    pixels = pixel_coordinates(SIZE).flatten(1).T
    plates = RBFInterpolator(points.numpy(), smooth(points).numpy())(pixels.numpy())
    ours = free_form(points, smooth(points), SIZE, tolerance=0.1).flatten(1).T.numpy()
    assert np.sqrt(np.square(ours - plates).mean() / np.square(plates).mean()) < 0.03


def test_one_displacement_moves_everything() -> None:
    displacement = free_form(torch.tensor([[30.0, 20.0]]), torch.tensor([[5.0, -3.0]]), SIZE, tolerance=1e-3)
    assert displacement[0, 20, 30] == pytest.approx(5, abs=0.01)
    assert displacement[1, 20, 30] == pytest.approx(-3, abs=0.01)


def test_no_displacement_is_exactly_none() -> None:
    assert not free_form(jittered(16), torch.zeros_like(jittered(16)), SIZE).any()


def test_a_periodic_warp_moves_with_its_points() -> None:
    points = torch.tensor([[2.0, 3.0], [50.0, 40.0]])
    ways = torch.tensor([[4.0, 2.0], [-3.0, 1.0]])
    here = free_form(points, ways, SIZE, wrap=True)
    # half the frame is a whole number of cells of every lattice along x
    there = free_form((points + torch.tensor([48.0, 0.0])) % torch.tensor([96.0, 64.0]), ways, SIZE, wrap=True)
    assert torch.allclose(there, here.roll(48, 2), atol=1e-4)


@pytest.mark.parametrize(
    ("points", "ways", "match"),
    [
        (torch.zeros(0, 2), torch.zeros(0, 2), r"give \(N, 2\)"),
        (torch.zeros(3, 2), torch.zeros(2, 2), r"give \(N, 2\)"),
        (torch.tensor([[float("nan"), 0]]), torch.zeros(1, 2), "NaN"),
    ],
)
def test_bad_points_are_refused(points: Tensor, ways: Tensor, match: str) -> None:
    with pytest.raises(InputError, match=match):
        free_form(points, ways, SIZE)
