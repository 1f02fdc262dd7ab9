import pytest
import torch

from kwatra.base import conjugate_gradients


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def system(size=40, coupling=1.0, dtype=torch.float64):
    """A random positive matrix, to which differences of neighbors are coupled."""
    root = torch.randn(size, size, generator=generator(), dtype=torch.float64)
    chain = torch.eye(size, dtype=torch.float64).diff(dim=0)
    matrix = 0.1 * root @ root.T + torch.eye(size, dtype=torch.float64) + coupling * chain.T @ chain
    return matrix.to(dtype), torch.randn(size, generator=generator(1), dtype=torch.float64).to(dtype)


def solved(matrix, right, *limits, start=None):
    start = torch.zeros_like(right) if start is None else start
    return conjugate_gradients(lambda v: matrix @ v, right, matrix.diagonal(), start, *limits)


@pytest.mark.parametrize("coupling", [0.0, 1.0, 1e4])
def test_they_agree_with_a_direct_solution(coupling):
    matrix, right = system(coupling=coupling)
    found = solved(matrix, right, 1e-12)
    assert found.residual <= 1e-12
    assert torch.allclose(found.x, torch.linalg.solve(matrix, right), atol=1e-8)


@pytest.mark.parametrize(("tolerance", "steps"), [(1e-3, 500), (1e-12, 7)])
def test_the_residual_that_is_told_is_that_of_the_solution(tolerance, steps):
    matrix, right = system(coupling=100.0)
    found = solved(matrix, right, tolerance, steps)
    assert found.residual == pytest.approx(float((right - matrix @ found.x).norm() / right.norm()), rel=1e-9)
    assert (found.residual <= tolerance) == (steps == 500)
    assert found.steps == 7 if steps == 7 else 7 < found.steps < 500


@pytest.mark.parametrize(("spread", "tolerance"), [(1e3, 1e-6), (1e5, 1e-5)])
def test_where_the_recursion_drifts_away_it_begins_anew(spread, tolerance):
    turn = torch.linalg.qr(torch.rand(60, 60, generator=generator(), dtype=torch.float64) - 0.5)[0]
    values = torch.logspace(0, torch.tensor(spread).log10().item(), 60, dtype=torch.float64)
    matrix = ((turn * values) @ turn.T).float()
    right = matrix @ torch.ones(60)
    found = conjugate_gradients(lambda v: matrix @ v, right, torch.ones(60), torch.zeros(60), tolerance, 2000)
    assert float((right - matrix @ found.x).norm() / right.norm()) <= tolerance


def test_what_rounding_forbids_is_not_tried_forever_nor_claimed():
    matrix, right = system(coupling=1e4, dtype=torch.float32)
    found = solved(matrix, right, 1e-12, 100_000)
    truth = float((right.double() - matrix.double() @ found.x.double()).norm() / right.double().norm())
    assert 1e-12 < truth < 1e-2
    assert found.residual == pytest.approx(truth, rel=0.5)
    assert found.steps < 10_000


def test_a_solution_is_kept_and_nothing_gives_nothing():
    matrix, right = system()
    exact = torch.linalg.solve(matrix, right)
    found = solved(matrix, right, 1e-6, start=exact)
    assert torch.equal(found.x, exact)
    assert found.steps == 0
    zero = solved(matrix, torch.zeros_like(right), start=exact)
    assert torch.equal(zero.x, torch.zeros_like(right))
    assert zero.residual == 0
