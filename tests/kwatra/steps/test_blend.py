import itertools
from dataclasses import replace

import pytest
import torch

from kwatra import Exemplar, Feature, Quadratic, SoftPixels, gradient
from kwatra.source.canvas import SourceWindows
from kwatra.steps.blend import blend
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
    x = blend(Ballot(grid, source, matches, weights)).x.double().requires_grad_(True)
    value = energy(x, source, grid, matches, weights)
    (slope,) = torch.autograd.grad(value, x)
    assert float(slope.abs().max()) < 1e-5
    other = x.detach() + 0.01 * torch.randn(x.shape, generator=generator())
    assert energy(other, source, grid, matches, weights) > value


def operator(weight=0.7):
    """An F that couples neighboring pixels: the square of a horizontal difference."""

    def apply(v):
        d = v.diff(dim=2)
        out = torch.zeros_like(v)
        out[:, :, 1:] += d
        out[:, :, :-1] -= d
        return weight * out

    diagonal = torch.full((2, 16, 20), 2 * weight)
    diagonal[:, :, 0] = diagonal[:, :, -1] = weight
    return Quadratic(diagonal, torch.rand(2, 16, 20, generator=generator(7)), apply)


@pytest.mark.parametrize("features", [(), (Feature(gradient, 3.0),)])
@pytest.mark.parametrize("coupled", [False, True])
def test_blend_with_terms_and_features_zeroes_the_gradient(features, coupled):
    source, grid, matches, weights = setting(features)
    target, weight = torch.rand(2, 16, 20, generator=generator(5)), torch.rand(1, 16, 20, generator=generator(6))
    quadratics = [SoftPixels(target, weight).quadratic(target)] + ([operator()] if coupled else [])
    x = blend(Ballot(grid, source, matches, weights), quadratics).x
    value = energy(x.double(), source, grid, matches, weights, quadratics)
    for seed in range(6):  # no direction leads further down
        direction = torch.randn(x.shape, generator=generator(seed)).double()
        for length in (1e-2, -1e-2):
            other = energy(x.double() + length * direction, source, grid, matches, weights, quadratics)
            assert other > value


def test_consistent_matches_give_the_exemplar_back():
    source, grid, _, weights = setting((Feature(gradient, 1.0),))
    matches = source.number(grid.corners + torch.tensor([3, 5]))
    x = blend(Ballot(grid, source, matches, weights)).x
    assert torch.allclose(x, source.exemplar.canvas[:, 3:19, 5:25], atol=1e-4)


def test_volumes_blend_like_images():
    source, grid, _, weights = setting(shape=(5, 12, 9), width=(4, 4, 4))
    matches = source.number(grid.corners + torch.tensor([1, 2, 3]))
    assert torch.allclose(
        blend(Ballot(grid, source, matches, weights)).x, source.exemplar.canvas[:, 1:6, 2:14, 3:12], atol=1e-6
    )


@pytest.mark.parametrize("wrap", [False, True])
def test_a_volumes_voxel_is_the_weighted_mean_of_all_windows_over_it(wrap):
    shape = (4, 8, 6)
    source, grid, matches, weights = setting(shape=shape, width=(3, 4, 4), wrap=wrap)
    total, mass = torch.zeros(2, *shape), torch.zeros(shape)
    for corner, window, weight in zip(grid.corners.tolist(), source.windows(matches), weights, strict=True):
        for t, y, x in itertools.product(range(3), range(4), range(4)):
            at = tuple((c + step) % side for c, step, side in zip(corner, (t, y, x), shape, strict=True))
            share = weight * source.metric.falloff[t, y, x, 0]
            total[(slice(None), *at)] += share * window[t, y, x]
            mass[at] += share
    assert torch.allclose(blend(Ballot(grid, source, matches, weights)).x, total / mass, atol=1e-5)


@pytest.mark.parametrize("given", [False, True])
def test_strong_coupling_is_solved_and_what_was_not_reached_is_told(given):
    source, grid, matches, weights = setting()
    coupled = replace(operator(1000.0), target=torch.zeros(2, 16, 20))
    fixed = torch.rand(2, 16, 20, generator=generator(9)) > (0.8 if given else 1.0)
    held = Given(fixed, torch.rand(2, 16, 20, generator=generator(10)), None) if given else None
    few = blend(Ballot(grid, source, matches, weights), [coupled], given=held, steps=5)
    assert few.steps == 5
    assert few.residual > 0.01
    goal = 2e-5 if given else 1e-4
    found = blend(Ballot(grid, source, matches, weights), [coupled], given=held, tolerance=goal)
    assert found.residual <= goal
    falloff = weights.double()[:, None, None, None] * source.metric.falloff
    mass, pulled = grid.scatter(falloff), grid.scatter(falloff * source.windows(matches))
    unit = mass.mean() if held is None else (mass * held.free).sum() / held.free.sum()
    units = torch.eye(fixed.numel(), dtype=torch.float64).view(-1, *fixed.shape)
    matrix = torch.stack([(mass / unit * e + coupled.times(e)).flatten() for e in units])
    right, free = (pulled / unit).flatten(), ~fixed.flatten()
    values = torch.zeros(2, 16, 20) if held is None else held.held(torch.zeros(2, 16, 20))
    right = (right - matrix @ values.flatten().double())[free]
    truth = values.flatten().double()
    truth[free] = torch.linalg.solve(matrix[free][:, free], right)
    assert torch.allclose(found.x.flatten().double(), truth, atol=2e-3)


@pytest.mark.parametrize("features", [(), (Feature(gradient, 3.0),)])
@pytest.mark.parametrize("coupled", [False, True])
def test_blend_around_fixed_and_masked_pixels_cannot_be_beaten(features, coupled):
    source, grid, matches, weights = setting(features)
    mask = torch.rand(1, 16, 20, generator=generator(8)) > 0.3
    fixed = (torch.rand(2, 16, 20, generator=generator(9)) > 0.8) | ~mask
    values = torch.rand(2, 16, 20, generator=generator(10)) * mask
    given = Given(fixed, values, mask)
    x = blend(Ballot(grid, source, matches, weights), [operator()] if coupled else [], given=given).x
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


def test_features_are_summed_band_by_band_into_one_image(monkeypatch):
    source, grid, matches, weights = setting(features=(Feature(gradient, 0.5),))
    whole = blend(Ballot(grid, source, matches, weights), tolerance=1e-6).x
    scatter, images = Grid.scatter, []

    def watched(self, windows, into=None):
        images.append((len(self), into))
        return scatter(self, windows, into)

    monkeypatch.setattr(Grid, "scatter", watched)
    monkeypatch.setattr("kwatra.steps.votes.chunk", lambda device: 16 * source.metric.weight.numel())
    parts = blend(Ballot(grid, source, matches, weights), tolerance=1e-6).x
    assert max(count for count, _ in images) <= 16 < len(grid)
    assert all(into is not None for _, into in images)
    addresses = {into.data_ptr() for _, into in images[:3]}
    assert len(addresses) < 3  # one after the other, not one each
    torch.testing.assert_close(parts, whole, rtol=0, atol=1e-4)
