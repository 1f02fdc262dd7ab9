"""Thin-plate splines against SciPy's, and what holds for any."""

import pytest
import torch
from scipy.interpolate import RBFInterpolator
from torch import Tensor

from synth.metamorphosis.patches.thin_plate import ThinPlates


def problems(count: int = 6, most: int = 14, dtype: torch.dtype = torch.float64) -> tuple[Tensor, Tensor, Tensor]:
    """Points on whole pixels of a patch, no two alike, with values; some of them padding."""
    generator = torch.Generator().manual_seed(0)
    pixels = torch.stack([torch.randperm(33 * 33, generator=generator)[:most] for _ in range(count)])
    points = torch.stack([pixels % 33, pixels // 33], 2).to(dtype)
    there = torch.arange(most) < torch.randint(4, most + 1, (count, 1), generator=generator)
    values = 3 * torch.randn(count, most, 2, dtype=dtype, generator=generator)
    return points, there, values


@pytest.mark.parametrize("smoothing", [0.0, 2.0, 300.0])
def test_splines_are_those_of_scipy(smoothing):
    points, there, values = problems()
    places = torch.rand(20, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 40 - 4
    plates = ThinPlates.of(points, there)
    splines = plates.splines(values, smoothing)
    made, bending = splines(places), splines.bending
    for k in range(len(points)):
        p, v = points[k][there[k]], values[k][there[k]]
        truth = RBFInterpolator(p, v, kernel="thin_plate_spline", smoothing=smoothing)
        torch.testing.assert_close(made[k], torch.from_numpy(truth(places)), atol=1e-6, rtol=1e-6)
        fitted = torch.from_numpy(truth(p))
        torch.testing.assert_close(plates.smoothed(values, smoothing)[k][there[k]], fitted, atol=1e-6, rtol=1e-6)
        if smoothing:  # the residuals of a smoothing spline are its weights, smoothing times
            energy = ((v - fitted) / smoothing * fitted).sum()
            torch.testing.assert_close(bending[k], energy, atol=1e-8, rtol=1e-6)


def test_single_precision_is_enough_for_patches():
    points, there, values = problems(40, 32, torch.float32)
    places = torch.cartesian_prod(torch.arange(33.0), torch.arange(33.0))
    rough = ThinPlates.of(points, there).splines(values, 5.0)(places)
    exact = ThinPlates.of(points.double(), there).splines(values.double(), 5.0)(places)
    assert float((rough - exact).abs().max()) < 0.01


def test_smoothing_and_slope_minimize_their_energy():
    """No other values at the points cost less; checked by the gradient, which is 0, and by trials."""
    points, there, values = problems(3, 9)
    plates = ThinPlates.of(points, there)
    smoothing, slope = 40.0, 25.0
    counted = there.double()[..., None]

    def energy(at: Tensor) -> Tensor:
        exact = plates.splines(at, 0.0)  # the least bending through these values
        tilt = (plates.planes.mT @ at)[:, 1:] / plates.extent[..., None]
        apart = ((at - values) * counted).square().sum((1, 2))
        return apart + smoothing * exact.bending + slope * tilt.square().sum((1, 2))

    best = plates.smoothed(values, smoothing, slope).requires_grad_()
    (gradient,) = torch.autograd.grad(energy(best).sum(), best)
    assert float((gradient * counted).abs().max()) < 1e-6
    noise = torch.randn(best.shape, dtype=best.dtype, generator=torch.Generator().manual_seed(2))
    assert bool((energy(best) < energy(best + 0.1 * noise * counted)).all())


def test_padding_changes_nothing_and_a_batch_is_its_members():
    points, there, values = problems()
    smoothing = torch.linspace(0, 50, len(points), dtype=torch.float64)
    places = torch.rand(len(points), 7, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 33
    plates = ThinPlates.of(points, there)
    made = plates.splines(values, smoothing, smoothing)(places)
    for k in range(len(points)):
        one = ThinPlates.of(points[k : k + 1, there[k]], there[k : k + 1, there[k]])
        alone = one.splines(values[k : k + 1, there[k]], float(smoothing[k]), float(smoothing[k]))
        torch.testing.assert_close(made[k], alone(places[k])[0], atol=1e-7, rtol=1e-7)
    moved = torch.where(there[..., None], points, 77.0), torch.where(there[..., None], values, -5.0)
    other = ThinPlates.of(moved[0], there).splines(moved[1], smoothing, smoothing)(places)
    assert torch.equal(made, other)


@pytest.mark.parametrize("smoothing", [0.0, 1e4])
def test_an_affine_motion_is_met(smoothing):
    points, there, _ = problems()
    matrix = torch.tensor([[0.2, -0.3], [0.1, 0.4]], dtype=torch.float64)
    places = torch.tensor([[-5.0, 3.0], [40.0, 33.0], [16.0, 16.0]], dtype=torch.float64)
    splines = ThinPlates.of(points, there).splines(points @ matrix + 7, smoothing)
    torch.testing.assert_close(splines(places), (places @ matrix + 7).expand(6, -1, -1), atol=1e-9, rtol=0)
    assert float(splines.bending.max()) < 1e-12


def test_few_points_and_points_on_a_line_leave_alone_what_they_do_not_know():
    points = torch.tensor([[[5.0, 5], [0, 0], [0, 0]], [[0, 0], [4, 4], [8, 8]], [[0, 0], [0, 0], [0, 0]]])
    there = torch.tensor([[True, False, False], [True, True, True], [False, False, False]])
    values = torch.tensor([[[1.0, 2], [9, 9], [9, 9]], [[0, 0], [1, 1], [2, 2]], [[9, 9], [9, 9], [9, 9]]])
    made = ThinPlates.of(points, there).splines(values, 1.0)(torch.tensor([[30.0, 0.0], [4.0, 4.0]]))
    torch.testing.assert_close(made[0], torch.tensor([[1.0, 2], [1, 2]]))
    torch.testing.assert_close(made[1], torch.tensor([[3.75, 3.75], [1, 1]]), atol=1e-4, rtol=0)  # along the line
    assert float(made[2].abs().max()) == 0


def test_threads_do_not_change_bits():
    points, there, values = problems(300, 24, torch.float32)
    places, threads, made = torch.rand(50, 2) * 33, torch.get_num_threads(), []
    try:
        for count in (1, 2):
            torch.set_num_threads(count)
            made.append(ThinPlates.of(points, there).splines(values, 3.0, 1.0)(places))
    finally:
        torch.set_num_threads(threads)
    assert torch.equal(*made)
