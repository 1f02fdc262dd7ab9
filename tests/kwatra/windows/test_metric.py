import pytest
import torch

from kwatra import Feature, InputError, gradient
from kwatra.windows.metric import Metric, falloff


def random(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed))


@pytest.mark.parametrize("width", [(8, 8), (5, 7), (4, 8, 8)])
def test_embedding_and_its_transpose_are_adjoint(width):
    metric = Metric(width, torch.tensor([1.0, 2.0]), (Feature(gradient, 0.7),))
    a = random(6, *width, 2)
    embedded = metric.embed(a)
    b = random(*embedded.shape, seed=1)
    assert torch.isclose((embedded * b).sum(), (a * metric.transposed(b)).sum(), rtol=1e-4)


def test_squared_is_the_length_of_the_embedding():
    metric = Metric((6, 6), torch.ones(3), (Feature(gradient, 2.0),))
    a = random(5, 6, 6, 3)
    assert torch.allclose(metric.squared(a), metric.embed(a).square().sum(1), rtol=1e-5)


def test_plain_metric_is_a_weighted_mean():
    metric = Metric((8, 8), torch.ones(3))
    assert torch.allclose(metric.squared(torch.full((1, 8, 8, 3), 0.5)), torch.tensor(0.25))
    assert float(falloff((8, 8)).sum()) == pytest.approx(1)
    assert falloff((8, 8))[4, 4] > falloff((8, 8))[0, 0]


@pytest.mark.parametrize("width", [7, 16, 32])
def test_the_falloffs_deviation_is_a_quarter_of_the_width(width):
    line = falloff((width,))
    place = torch.arange(width) - (width - 1) / 2
    one = float(-place[0].square() / (2 * (line[0] / line[width // 2]).log()))  # of exp(-t^2 / 2 s^2), s^2 about
    assert one**0.5 == pytest.approx(width / 4, rel=0.03)


def test_a_features_mean_square_counts_mu_times_the_colors():
    metric = Metric((6, 8), torch.ones(2), (Feature(lambda windows: windows[:, 1:3, 2:7], 0.7),))
    flat = torch.full((1, 6, 8, 2), 0.5)  # whatever is taken of it has the mean square of its colors
    assert float(metric.squared(flat)) == pytest.approx(1.7 * 0.25)


def test_a_channel_of_weight_zero_does_not_count():
    metric = Metric((4, 4), torch.tensor([1.0, 0.0]))
    difference = torch.zeros(1, 4, 4, 2)
    difference[..., 1] = 9.0
    assert float(metric.squared(difference)) == 0.0


def test_gradient_ignores_brightness_and_sees_edges():
    flat = torch.full((1, 4, 4, 1), 3.0)
    edge = flat.clone()
    edge[:, :, 2:] += 1
    assert float(gradient(flat).abs().max()) == 0
    assert float(gradient(edge).square().sum()) == 4.0  # one unit step in each of four rows


def test_features_diagonal_is_that_of_the_normal_matrix():
    metric = Metric((4, 5), torch.ones(2), (Feature(gradient, 1.5),))
    unit = torch.eye(40).view(40, 4, 5, 2)
    matrix = metric.features(unit) @ metric.features(unit).T
    assert torch.allclose(metric.features_diagonal.flatten(), matrix.diagonal(), rtol=1e-5)


def test_a_feature_that_is_not_linear_is_refused():
    with pytest.raises(InputError, match="psi must be linear"):
        Metric((4, 4), torch.ones(1), (Feature(lambda w: w + 1),))
