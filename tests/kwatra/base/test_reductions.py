"""Sums, products, powers and angles: right, and the same bits for any number of threads."""

import numpy as np
import pytest
import torch

from kwatra.base import atan2, mean, over_channels, power, principal_axes, product, total


@pytest.mark.parametrize("shape", [(1, 4356, 24), (20, 867, 24), (100, 768, 32), (3000, 1156, 24), (24, 3000, 32)])
def test_products_do_not_depend_on_threads(shape: tuple[int, int, int]) -> None:
    generator = torch.Generator().manual_seed(0)
    a, b = torch.rand(shape[0], shape[1], generator=generator), torch.rand(shape[1], shape[2], generator=generator)
    found = []
    for count in (1, 2, 4):
        torch.set_num_threads(count)
        found.append(product(a, b))
    assert all(torch.equal(found[0], other) for other in found)
    assert torch.allclose(found[0], (a.double() @ b.double()).float(), rtol=1e-5)


def test_sums_do_not_depend_on_threads() -> None:
    values = torch.rand(100, 12345, generator=torch.Generator().manual_seed(0))
    found = []
    for count in (1, 2):
        torch.set_num_threads(count)
        found.append(total(values))
    assert torch.equal(found[0], found[1])
    assert float(mean(values)) == pytest.approx(float(values.double().mean()), rel=1e-6)


@pytest.mark.parametrize("channels", [1, 3, 6, 9])
def test_sums_over_channels_do_not_depend_on_threads(channels: int) -> None:
    values = torch.rand(channels, 401, 403, generator=torch.Generator().manual_seed(0))
    found = []
    for count in (1, 2, 3):
        torch.set_num_threads(count)
        found.append(over_channels(values))
    assert all(torch.equal(found[0], other) for other in found)
    assert torch.allclose(found[0], values.double().sum(0).float(), rtol=1e-6)
    assert torch.equal(values, torch.rand(values.shape, generator=torch.Generator().manual_seed(0)))  # as they were


@pytest.mark.parametrize(
    ("made", "by_hand"),
    [
        (lambda x, y: power(x, -0.6), lambda x, y: x**-0.6),
        (lambda x, y: atan2(y - 0.5, x - 0.5), lambda x, y: np.arctan2(y - 0.5, x - 0.5)),
    ],
)
def test_powers_and_angles_do_not_depend_on_threads(made, by_hand) -> None:
    x, y = torch.rand(2, 255, 255, generator=torch.Generator().manual_seed(0))  # no share of which is whole vectors
    found = []
    for count in (1, 2, 3):
        torch.set_num_threads(count)
        found.append(made(x, y))
    assert all(torch.equal(found[0], other) for other in found)
    np.testing.assert_allclose(found[0], by_hand(*(values.double().numpy() for values in (x, y))), rtol=1e-4)


def test_principal_axes_are_those_of_an_ellipse_longest_first() -> None:
    turned = torch.tensor([[0.8, -0.6], [0.6, 0.8]])
    values = turned @ (torch.tensor([[1.0], [3.0]]) * torch.randn(2, 5000, generator=torch.Generator().manual_seed(0)))
    axes = principal_axes(values.double() + 10)
    assert torch.allclose(axes @ axes.T, torch.eye(2, dtype=torch.float64))
    assert float((axes @ turned.double().flip(1)).abs().diagonal().min()) > 0.999
