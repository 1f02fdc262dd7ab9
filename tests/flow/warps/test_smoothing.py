"""The operator L and its inverse: against the Laplacian of five points, borders without flow, adjointness."""

import pytest
import torch
import torch.nn.functional as F

from flow.warps.smoothing import Smoothness
from kwatra import InputError


def flows(*shape: int) -> torch.Tensor:
    return torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(0))


def laplacian(padded: torch.Tensor) -> torch.Tensor:
    middle = padded[..., 1:-1, 1:-1]
    return padded[..., 2:, 1:-1] + padded[..., :-2, 1:-1] + padded[..., 1:-1, 2:] + padded[..., 1:-1, :-2] - 4 * middle


def padded(flow: torch.Tensor, wrap: bool) -> torch.Tensor:
    """A pixel more on each side: what tiles, or mirrored, with the sign changed for flow across the border."""
    if wrap:
        return F.pad(flow, (1, 1, 1, 1), "circular")
    wide = F.pad(flow, (1, 1, 1, 1), "replicate")
    wide[:, 0, :, [0, -1]] *= -1
    wide[:, 1, [0, -1], :] *= -1
    return wide


@pytest.mark.parametrize("wrap", [False, True])
def test_it_is_the_laplacian_of_five_points(wrap):
    flow = flows(3, 2, 7, 10)
    expected = -1.7 * laplacian(padded(flow, wrap)) + 0.3 * flow
    torch.testing.assert_close(Smoothness(1.7, 0.3, wrap).applied(flow), expected)


@pytest.mark.parametrize("wrap", [False, True])
def test_the_inverse_undoes_it_and_both_are_symmetric(wrap):
    smoothness, flow, other = Smoothness(2.0, 0.1, wrap), flows(3, 2, 7, 10), flows(6, 2, 7, 10)[3:]
    torch.testing.assert_close(smoothness.inverted(smoothness.applied(flow)), flow)
    for apply in (smoothness.applied, smoothness.inverted):
        torch.testing.assert_close((apply(flow) * other).sum(), (flow * apply(other)).sum())


def test_nothing_flows_through_the_border():
    flow = Smoothness(50.0, 0.01).inverted(torch.ones(1, 2, 32, 32, dtype=torch.float64))[0]
    across, along = flow[0, 16], flow[0, :, 16]
    assert float(across[0]) < 0.15 * float(across[16])
    assert float(along.std()) < 0.01 * float(along.mean())


@pytest.mark.parametrize(("alpha", "gamma"), [(0, 1), (1, 0), (-1, 1), (float("nan"), 1), (1, float("inf"))])
def test_weights_that_are_none_are_refused(alpha, gamma):
    with pytest.raises(InputError, match="finite numbers above 0"):
        Smoothness(alpha, gamma)
