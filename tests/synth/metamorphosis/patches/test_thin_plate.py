"""Thin-plate splines against SciPy's, and what holds for any."""

import pytest
import torch
from scipy.interpolate import RBFInterpolator
from torch import Tensor

from synth.metamorphosis.patches.thin_plate import Splines, ThinPlates

WIDTH = 33.0
FREE = 1e6


def problems(count: int = 6, most: int = 14, dtype: torch.dtype = torch.float64) -> tuple[Tensor, Tensor, Tensor]:
    """Points on whole pixels of a patch, no two alike, with values; some of them padding."""
    generator = torch.Generator().manual_seed(0)
    pixels = torch.stack([torch.randperm(33 * 33, generator=generator)[:most] for _ in range(count)])
    points = torch.stack([pixels % 33, pixels // 33], 2).to(dtype)
    there = torch.arange(most) < torch.randint(4, most + 1, (count, 1), generator=generator)
    values = 3 * torch.randn(count, most, 2, dtype=dtype, generator=generator)
    return points, there, values


@pytest.mark.parametrize("smoothing", [0.0, 2.0, 300.0])
def test_where_tilting_is_free_splines_are_those_of_scipy(smoothing):
    points, there, values = problems()
    places = torch.rand(20, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 40 - 4
    plates = ThinPlates.of(points, there, WIDTH, FREE)
    splines = plates.splines(values, smoothing)
    made = splines(places)
    for k in range(len(points)):
        p, v = points[k][there[k]], values[k][there[k]]
        truth = RBFInterpolator(p, v, kernel="thin_plate_spline", smoothing=smoothing)
        torch.testing.assert_close(made[k], torch.from_numpy(truth(places)), atol=1e-4, rtol=0)
        fitted = torch.from_numpy(truth(p))
        torch.testing.assert_close(plates.smoothed(values, smoothing)[k][there[k]], fitted, atol=1e-4, rtol=0)
        if smoothing:  # the residuals of a smoothing spline are its weights, smoothing times
            energy = ((v - fitted) / smoothing * fitted).sum()
            torch.testing.assert_close(splines.penalty[k], energy, atol=1e-6, rtol=1e-3)


def test_the_splines_are_what_is_smoothed():
    points, there, values = problems()
    plates = ThinPlates.of(points, there, WIDTH, 2.0)
    made = plates.splines(values, 30.0)(points)
    torch.testing.assert_close(made[there], plates.smoothed(values, 30.0)[there], atol=1e-9, rtol=0)


def test_single_precision_is_enough_for_patches():
    points, there, values = problems(40, 32, torch.float32)
    places = torch.cartesian_prod(torch.arange(33.0), torch.arange(33.0))
    rough = ThinPlates.of(points, there, WIDTH, 2.0).splines(values, 5.0)(places)
    exact = ThinPlates.of(points.double(), there, WIDTH, 2.0).splines(values.double(), 5.0)(places)
    assert float((rough - exact).abs().max()) < 0.01


def test_no_other_spline_costs_less():
    """Bending, by its integral, and the slope of the plane at the corners, of the best spline and of others."""
    points, there, values = problems(3, 9)
    plates, smoothing, tilt = ThinPlates.of(points, there, WIDTH, 2.0), 40.0, 2.0
    best, counted = plates.splines(values, smoothing), there.double()[..., None]
    corners = WIDTH * torch.tensor([[0.0, 0], [1, 0], [0, 1], [1, 1]], dtype=torch.float64)
    away = torch.tensor([-1.0, 1.0], dtype=torch.float64)

    def energy(splines: Splines) -> Tensor:
        kernels = torch.cdist(splines.points, splines.points)
        kernels = kernels.square() * kernels.clamp(min=1e-30).log()
        bending = (splines.weights * (kernels @ splines.weights)).sum((1, 2))
        at = splines(corners).view(-1, 2, 2, 2)  # row, column, component
        slope = torch.stack([torch.einsum("brck,c->bk", at, away), torch.einsum("brck,r->bk", at, away)]) / (2 * WIDTH)
        misfit = ((splines(points) - values) * counted).square().sum((1, 2))
        penalty = bending + slope.square().sum((0, 2)) / tilt
        torch.testing.assert_close(penalty, splines.penalty, atol=1e-8, rtol=1e-6)
        return misfit + smoothing * penalty

    noise = torch.randn(values.shape, dtype=values.dtype, generator=torch.Generator().manual_seed(2))
    for size in (-0.5, 0.01, 0.5):
        other = plates.splines(values + size * noise, smoothing)
        assert bool((energy(best) < energy(other)).all())
    for factor in (0.5, 0.99, 1.01, 2.0):
        assert bool((energy(best) < energy(plates.splines(values, factor * smoothing))).all())


def test_padding_changes_nothing_and_a_batch_is_its_members():
    points, there, values = problems()
    smoothing = torch.linspace(0, 50, len(points), dtype=torch.float64)
    places = torch.rand(len(points), 7, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 33
    made = ThinPlates.of(points, there, WIDTH, 2.0).splines(values, smoothing)(places)
    for k in range(len(points)):
        one = ThinPlates.of(points[k : k + 1, there[k]], there[k : k + 1, there[k]], WIDTH, 2.0)
        alone = one.splines(values[k : k + 1, there[k]], float(smoothing[k]))
        torch.testing.assert_close(made[k], alone(places[k])[0], atol=1e-7, rtol=1e-7)
    moved = torch.where(there[..., None], points, 77.0), torch.where(there[..., None], values, -5.0)
    other = ThinPlates.of(moved[0], there, WIDTH, 2.0).splines(moved[1], smoothing)(places)
    assert torch.equal(made, other)


@pytest.mark.parametrize("smoothing", [0.0, 300.0])
def test_an_affine_motion_is_met(smoothing):
    points, there, _ = problems()
    matrix = torch.tensor([[0.2, -0.3], [0.1, 0.4]], dtype=torch.float64)
    places = torch.tensor([[-5.0, 3.0], [40.0, 33.0], [16.0, 16.0]], dtype=torch.float64)
    splines = ThinPlates.of(points, there, WIDTH, FREE).splines(points @ matrix + 7, smoothing)
    torch.testing.assert_close(splines(places), (places @ matrix + 7).expand(6, -1, -1), atol=1e-3, rtol=0)


def test_where_nothing_is_known_nothing_tilts():
    """A point shifts all; a line of pixels that bends says nothing of what is beside it; no point leaves all alone."""
    line = torch.tensor([[4.0, 16], [8, 17], [12, 16], [16, 17], [20, 16], [24, 17], [28, 16]])
    bent = torch.stack([torch.zeros(7), 0.02 * (line[:, 0] - 16).square()], 1)
    points = torch.stack([line, line, line])
    there = torch.tensor([[True] * 7, [True] + [False] * 6, [False] * 7])
    values = torch.stack([bent, torch.tensor([1.0, 2]).expand(7, 2), bent])
    made = ThinPlates.of(points, there, WIDTH, 2.0).splines(values, 5.0)(torch.tensor([[16.0, 0], [16, 32], [0, 16]]))
    assert float(made[0].abs().max()) < 4
    torch.testing.assert_close(made[1], torch.tensor([1.0, 2]).expand(3, 2))
    assert float(made[2].abs().max()) == 0


def test_threads_do_not_change_bits():
    points, there, values = problems(300, 24, torch.float32)
    places = torch.cartesian_prod(torch.arange(0.0, 33, 4), torch.arange(0.0, 33, 4))
    made = []
    for count in (1, 2):
        torch.set_num_threads(count)
        made.append(ThinPlates.of(points, there, WIDTH, 2.0).splines(values, 3.0)(places))
    assert torch.equal(*made)
