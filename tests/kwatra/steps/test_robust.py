import pytest
import torch

from kwatra.steps.robust import rho, weight


@pytest.mark.parametrize("r", [0.5, 0.8, 1.0, 2.0])
def test_weight_is_the_derivative_of_rho(r):
    squared = torch.linspace(1e-4, 1, 50, dtype=torch.float64, requires_grad=True)
    (derivative,) = torch.autograd.grad(rho(squared, r).sum(), squared)
    assert torch.allclose(weight(squared.detach(), r) * r / 2, derivative)


@pytest.mark.parametrize("r", [0.5, 0.8, 1.5])
def test_the_weighted_square_majorizes_rho(r):
    # what makes IRLS decrease the robust energy: the parabola touches rho and lies above it
    at = torch.tensor(0.3, dtype=torch.float64)
    squared = torch.linspace(0, 1, 100, dtype=torch.float64)
    parabola = rho(at, r) + r / 2 * weight(at, r) * (squared - at)
    assert bool((parabola >= rho(squared, r) - 1e-12).all())
    assert float(rho(at, r)) == pytest.approx(0.3 ** (r / 2), rel=1e-4)
