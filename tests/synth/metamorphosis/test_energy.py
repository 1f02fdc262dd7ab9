"""The energy's gradient: against finite differences, and against the paper's adjoint solution (eq. 6 to 10)."""

import pytest
import torch
from scipy.ndimage import gaussian_filter

from flow.warps import pixel_coordinates, warp
from flow.warps.integration import displacement, interpolated, jacobian
from flow.warps.smoothing import Smoothness
from kwatra.base import mean
from synth.metamorphosis.optimal_control.energy import Change
from synth.metamorphosis.optimal_control.film import frames
from synth.metamorphosis.velocity import Mismatch, Search, SearchLevel


def smooth(*shape: int, blur: float, seed: int = 0) -> torch.Tensor:
    values = torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(seed)).numpy()
    blurred = gaussian_filter(values, [0] * (len(shape) - 2) + [blur, blur])
    return torch.from_numpy(blurred / blurred.std())


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("kind", ["change", "features", "mismatch"])
def test_the_gradient_is_that_of_finite_differences(kind, wrap):
    """On 12x12 px in double precision they differ by less than 1e-6 of the gradient."""
    images = smooth(2, 3, 12, 12, blur=1.5)
    lack = {
        "change": Change(images, 3, 1.0, wrap),
        "features": Change(images, 2, 0.7, wrap),
        "mismatch": Mismatch(images, 0.5, wrap),
    }[kind]
    oracle = SearchLevel(Search(2.0, 0.5, 3, 1, 0.0), 1, lack, wrap).oracle()
    control = 0.4 * smooth(3, 2, 12, 12, blur=1.0, seed=1)
    direction = smooth(3, 2, 12, 12, blur=0.5, seed=2)
    _, gradient = oracle(control)
    step = 1e-5
    rise = (oracle(control + step * direction)[0] - oracle(control - step * direction)[0]) / (2 * step)
    slope = float((gradient * direction).sum())
    assert abs(rise - slope) < 1e-6 * abs(slope) + 1e-9
    assert abs(slope) > 1e-4


def adjoint_gradient(velocity: torch.Tensor, a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """lambda DI^T at the middle of each step, forward and backward solution weighted by time (eq. 10)."""
    pixels, steps = pixel_coordinates(a.shape[1:]).double(), len(velocity)

    def final(velocity: torch.Tensor, source: torch.Tensor, target: torch.Tensor) -> torch.Tensor:
        """q(1) of equation 8."""
        unmoved = warp(source, pixels + displacement(velocity, 1, 0))
        areas = [jacobian(displacement(velocity, 1, k / steps)) for k in range(steps + 1)]
        density = torch.stack([1 / area for area in areas])
        return (target - unmoved) / ((density[1:] + density[:-1]) / 2).mean(0)

    def multiplier(velocity: torch.Tensor, source: torch.Tensor, target: torch.Tensor, time: float) -> torch.Tensor:
        """lambda(t) = 2 q(t), carried back with the Jacobian (equation 6)."""
        ahead = displacement(velocity, time, 1)
        return 2 * jacobian(ahead) * interpolated(final(velocity, source, target), pixels + ahead)

    gradients = []
    for k in range(steps):
        time = (k + 0.5) / steps
        (picture,) = frames(velocity, a, b, [time])
        forward = multiplier(velocity, a, b, time)
        backward = -multiplier(-velocity.flip(0), b, a, 1 - time)
        weighted = (1 - time) * forward + time * backward
        slopes = torch.stack(torch.gradient(picture, dim=(2, 1)))
        gradients.append((slopes * weighted).sum(1) / pixels[0].numel())
    return torch.stack(gradients)


def test_the_gradient_is_the_papers_but_for_the_grid():
    """On 48x48 px of blobs of 5 px that move by up to 12, the gradient for u = L v, as the descent takes it.

    Differentiated after discretizing, as here, or before, as in the paper, it differs by 7 % of its norm; at the
    border, where both read what is not there, by more.
    """
    a, b = 0.5 + 0.1 * smooth(2, 2, 48, 48, blur=5.0)
    smoothness = Smoothness(20.0, 1.0)
    velocity = smoothness.inverted(3 * smooth(5, 2, 48, 48, blur=4.0, seed=1)).requires_grad_()
    energy = sum(energies["change"] for energies, _ in Change(torch.stack([a, b]), 2, 1.0)(velocity))
    (exact,) = torch.autograd.grad(energy, velocity)
    velocity = velocity.detach()
    assert float(displacement(velocity, 0, 1).norm(dim=0).max()) > 10
    closed, exact = (
        smoothness.inverted(gradient)[..., 6:-6, 6:-6] for gradient in (adjoint_gradient(velocity, a, b), exact)
    )
    assert float((closed - exact).norm() / exact.norm()) < 0.08


@pytest.mark.parametrize("maps", [1, 3, 100])
def test_maps_looked_at_together_cost_what_they_cost_alone(monkeypatch, maps):
    """One by one, some at a time with a rest, and all at once."""
    images, velocity = smooth(2, 1, 10, 10, blur=2.0), 0.3 * smooth(6, 2, 10, 10, blur=2.0, seed=1)
    monkeypatch.setattr("synth.metamorphosis.optimal_control.energy._AT_ONCE", 200 * 4)
    expected = [(float(parts["change"]), float(least)) for parts, least in Change(images, 1, 1.0)(velocity)]
    monkeypatch.setattr("synth.metamorphosis.optimal_control.energy._AT_ONCE", 200 * maps)
    found = [(float(parts["change"]), float(least)) for parts, least in Change(images, 1, 1.0)(velocity)]
    assert found == [pytest.approx(pair, rel=1e-12) for pair in expected]


WEIGHTS = torch.tensor([0.5, 1, 1, 1, 0.5], dtype=torch.float64).view(-1, 1, 1) / 4
"""Of times 0, 1/4, ... 1 in an integral."""


def way(velocity: torch.Tensor, a: torch.Tensor, b: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """What has to change, (H, W), in the coordinates of B, and the area of its pixels at times 0, 1/4, ... 1."""
    steps = torch.stack([displacement(velocity, 1, k / 4) for k in range(5)])
    return (b - interpolated(a, pixel_coordinates((24, 24)).double() + steps[0], "bicubic"))[0], jacobian(steps)


def cost(change: torch.Tensor, area: torch.Tensor) -> float:
    """|q|^2 of changes (5, H, W) in the coordinates of B, where a pixel covers `area`."""
    return float(mean((WEIGHTS * change.square() * area).sum(0)))


def test_the_least_change_is_the_least():
    """No other q that leads from A to B along the same velocity costs less than that of equation 8."""
    a, b = smooth(2, 1, 24, 24, blur=3.0)
    velocity = Smoothness(20.0, 1.0).inverted(3 * smooth(4, 2, 24, 24, blur=3.0, seed=1))
    generator, least = torch.Generator().manual_seed(3), []
    for forward, source, target in ((velocity, a, b), (-velocity.flip(0), b, a)):
        missing, area = way(forward, source, target)
        best = missing / (area * (WEIGHTS / area).sum(0))
        least.append(cost(best, area))
        for _ in range(5):
            other = best + 0.3 * torch.randn(5, 24, 24, dtype=torch.float64, generator=generator)
            other = other + (missing - (WEIGHTS * other).sum(0))
            assert cost(other, area) > least[-1]
    energy = sum(float(energies["change"]) for energies, _ in Change(torch.stack([a, b]), 1, 1.0)(velocity))
    assert energy == pytest.approx(sum(least) / 2, rel=1e-9)
    assert least[0] != pytest.approx(float(mean(way(velocity, a, b)[0].square())), rel=0.01)
