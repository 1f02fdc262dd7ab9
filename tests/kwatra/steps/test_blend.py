import pytest
import torch

from kwatra import Exemplar, Feature, Quadratic, SoftPixels, gradient
from kwatra.source.canvas import SourceWindows
from kwatra.steps.blend import blend, conjugate_gradients
from kwatra.steps.votes import Ballot
from kwatra.terms.controls import Given
from kwatra.windows.grid import Grid


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def setting(features=(), shape=(16, 20), width=(8, 8), channels=2, wrap=False):
    image = torch.rand(channels, *(s + 9 for s in shape), generator=generator())
    source = SourceWindows(Exemplar.of(image), width, generator(1), features=features)
    grid = Grid(shape, width, tuple(max(w // 4, 1) for w in width), wrap)
    pick = torch.randint(len(source.numbers), (len(grid),), generator=generator(2))
    weights = torch.rand(len(grid), generator=generator(3)) + 0.1
    return source, grid, source.numbers[pick], weights


def energy(x, source, grid, matches, weights, quadratics=()):
    """The energy that blend minimizes, straight from its definition, in double precision."""
    difference = grid.gather(x) - source.windows(matches).double()
    metric = source.metric
    w = weights.double()
    color = (difference.square() * metric.falloff).flatten(1).sum(1)
    scale = (w[:, None, None, None] * torch.ones(1, *grid.width, 1) * metric.falloff).sum() / x[0].numel()
    total = (w * color).sum() / scale
    if not metric.plain:
        total = total + (w * metric.features(difference.float()).double().square().sum(1)).sum() / scale
    for q in quadratics:
        error = x - q.target
        total = total + (error * q.times(error.float())).sum()
    return total


@pytest.mark.parametrize("wrap", [False, True])
def test_plain_blend_is_the_weighted_mean_and_cannot_be_beaten(wrap):
    source, grid, matches, weights = setting(wrap=wrap)
    x = blend(Ballot(grid, source, matches, weights)).double().requires_grad_(True)
    value = energy(x, source, grid, matches, weights)
    (slope,) = torch.autograd.grad(value, x)
    assert float(slope.abs().max()) < 1e-5
    other = x.detach() + 0.01 * torch.randn(x.shape, generator=generator())
    assert energy(other, source, grid, matches, weights) > value


def operator():
    """An F that couples neighboring pixels: the square of a horizontal difference."""

    def apply(v):
        d = v.diff(dim=2)
        out = torch.zeros_like(v)
        out[:, :, 1:] += d
        out[:, :, :-1] -= d
        return 0.7 * out

    diagonal = torch.full((2, 16, 20), 1.4)
    diagonal[:, :, 0] = diagonal[:, :, -1] = 0.7
    return Quadratic(diagonal, torch.rand(2, 16, 20, generator=generator(7)), apply)


@pytest.mark.parametrize("features", [(), (Feature(gradient, 3.0),)])
@pytest.mark.parametrize("coupled", [False, True])
def test_blend_with_terms_and_features_zeroes_the_gradient(features, coupled):
    source, grid, matches, weights = setting(features)
    target, weight = torch.rand(2, 16, 20, generator=generator(5)), torch.rand(1, 16, 20, generator=generator(6))
    quadratics = [SoftPixels(target, weight).quadratic(target)] + ([operator()] if coupled else [])
    x = blend(Ballot(grid, source, matches, weights), quadratics)
    value = energy(x.double(), source, grid, matches, weights, quadratics)
    for seed in range(6):  # no direction leads further down
        direction = torch.randn(x.shape, generator=generator(seed)).double()
        for length in (1e-2, -1e-2):
            other = energy(x.double() + length * direction, source, grid, matches, weights, quadratics)
            assert other > value


def test_consistent_matches_give_the_exemplar_back():
    source, grid, _, weights = setting((Feature(gradient, 1.0),))
    matches = source.number(grid.corners + torch.tensor([3, 5]))
    x = blend(Ballot(grid, source, matches, weights))
    assert torch.allclose(x, source.exemplar.canvas[:, 3:19, 5:25], atol=1e-4)


def test_volumes_blend_like_images():
    source, grid, _, weights = setting(shape=(5, 12, 9), width=(4, 4, 4))
    matches = source.number(grid.corners + torch.tensor([1, 2, 3]))
    x = blend(Ballot(grid, source, matches, weights))
    assert torch.allclose(x, source.exemplar.canvas[:, 1:6, 2:14, 3:12], atol=1e-6)


def test_conjugate_gradients_agree_with_a_direct_solution():
    root = torch.randn(30, 30, generator=generator(), dtype=torch.float64)
    matrix = root @ root.T + torch.eye(30, dtype=torch.float64)
    right = torch.randn(30, generator=generator(1), dtype=torch.float64)
    x = conjugate_gradients(lambda v: matrix @ v, right, matrix.diagonal(), torch.zeros_like(right), 1e-12, 200)
    assert torch.allclose(x, torch.linalg.solve(matrix, right), atol=1e-8)


@pytest.mark.parametrize("features", [(), (Feature(gradient, 3.0),)])
@pytest.mark.parametrize("coupled", [False, True])
def test_blend_around_fixed_and_masked_pixels_cannot_be_beaten(features, coupled):
    source, grid, matches, weights = setting(features)
    mask = torch.rand(1, 16, 20, generator=generator(8)) > 0.3
    fixed = (torch.rand(2, 16, 20, generator=generator(9)) > 0.8) | ~mask
    values = torch.rand(2, 16, 20, generator=generator(10)) * mask
    given = Given(fixed, values, mask)
    x = blend(Ballot(grid, source, matches, weights), [operator()] if coupled else [], given=given)
    assert torch.equal(x[fixed], values[fixed])
    metric, present = source.metric, grid.gather(mask.double())
    matched, falloff = source.windows(matches).double(), metric.falloff.double()
    free = (~fixed).any(0, keepdim=True)
    mass = grid.scatter(weights.double()[:, None, None, None] * falloff.expand(len(grid), *falloff.shape))
    unit = (mass * free).sum() / free.sum()

    def value(image):
        """Every window on its unmasked pixels, straight from the definition."""
        difference = present * (grid.gather(image) - matched)
        total = (weights.double() / unit * (difference.square() * falloff).flatten(1).sum(1)).sum()
        if features:
            total += (weights.double() / unit * metric.features(difference.float()).double().square().sum(1)).sum()
        if coupled:
            error = image - operator().target
            total += (error * operator().times(error.float())).sum()
        return total

    least = value(x.double())
    for seed in range(6):
        direction = torch.randn(x.shape, generator=generator(seed)).double() * ~fixed
        for length in (1e-2, -1e-2):
            assert value(x.double() + length * direction) > least
