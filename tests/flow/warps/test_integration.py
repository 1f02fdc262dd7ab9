"""Velocities integrated into maps: known motions, there and back, Jacobians."""

import math

import pytest
import torch

from flow.warps import pixel_coordinates, warp
from flow.warps.integration import again, displaced, displacement, followed, interpolated, jacobian


def turning(size: int, radians: float) -> torch.Tensor:
    """The flow of a rotation about the middle, px per unit of time."""
    x, y = pixel_coordinates((size, size)) - (size - 1) / 2
    return radians * torch.stack([-y, x])


def test_a_steady_shift_adds_up():
    velocity = torch.tensor([1.5, -0.5]).view(1, 2, 1, 1).expand(4, 2, 12, 12)
    moved = displaced(velocity)
    assert moved.shape == (5, 2, 12, 12)
    expected = torch.arange(5.0).view(5, 1) * torch.tensor([1.5, -0.5])
    torch.testing.assert_close(moved, expected.view(5, 2, 1, 1).expand(-1, -1, 12, 12))


def test_particles_of_a_rotation_go_round_in_circles():
    velocity = turning(41, 0.6).expand(12, 2, 41, 41) / 12
    end = displaced(velocity)[-1] + pixel_coordinates((41, 41)) - 20
    x, y = pixel_coordinates((41, 41)) - 20
    expected = torch.stack([math.cos(0.6) * x - math.sin(0.6) * y, math.sin(0.6) * x + math.cos(0.6) * y])
    inside = x.square() + y.square() < 18**2
    assert float((end - expected).norm(dim=0)[inside].max()) < 0.02


def test_there_and_back_is_where_one_was():
    velocity = turning(41, 0.6).expand(12, 2, 41, 41) / 12
    there, back = displacement(velocity, 0, 1), displacement(velocity, 1, 0)
    x, y = pixel_coordinates((41, 41)) - 20
    round_trip = there + warp(back, pixel_coordinates((41, 41)) + there, "bilinear")
    assert float(round_trip.norm(dim=0)[x.square() + y.square() < 18**2].max()) < 0.02


@pytest.mark.parametrize("wrap", [False, True])
def test_back_in_time_is_along_what_is_turned_round(wrap):
    velocity = torch.randn(3, 2, 8, 9, generator=torch.Generator().manual_seed(0))
    turned = followed(-velocity.flip(0), wrap)
    for back, expected in zip(followed(velocity, wrap, back=True), turned, strict=True):
        assert torch.equal(back, expected)


@pytest.mark.parametrize(("start", "end", "steps"), [(0, 0.5, 2), (0.25, 0.875, 2.5), (1, 0.5, -2), (0.3, 0.3, 0)])
def test_steps_count_in_part(start, end, steps):
    velocity = torch.ones(4, 2, 8, 8)
    torch.testing.assert_close(displacement(velocity, start, end), torch.full((2, 8, 8), float(steps)))


def test_a_map_that_scales_stretches_area_by_its_square():
    centered = pixel_coordinates((9, 11)) - torch.tensor([5.0, 4.0]).view(2, 1, 1)
    torch.testing.assert_close(jacobian(0.5 * centered), torch.full((9, 11), 2.25))
    assert float(jacobian(-1.2 * centered[:1] * torch.tensor([1.0, 0.0]).view(2, 1, 1)).max()) < 0


def test_a_linear_map_stretches_area_by_its_determinant():
    matrix = torch.tensor([[1.3, 0.4], [-0.7, 0.9]])
    place = pixel_coordinates((9, 11))
    moved = torch.einsum("ij,jhw->ihw", matrix, place) - place
    torch.testing.assert_close(jacobian(moved), torch.full((9, 11), 1.3 * 0.9 + 0.4 * 0.7), atol=1e-5, rtol=0)


def test_a_periodic_frame_has_no_border():
    generator = torch.Generator().manual_seed(0)
    velocity = torch.randn(3, 2, 10, 12, generator=generator)
    here, there = displaced(velocity, wrap=True), displaced(velocity.roll((3, 5), (-2, -1)), wrap=True)
    torch.testing.assert_close(here.roll((3, 5), (-2, -1)), there, atol=1e-4, rtol=0)
    torch.testing.assert_close(jacobian(here, True).roll((3, 5), (-2, -1)), jacobian(there, True), atol=1e-4, rtol=1e-4)
    assert not torch.allclose(displaced(velocity)[-1], here[-1])


@pytest.mark.parametrize("wrap", [False, True])
def test_reading_agrees_with_warp(wrap):
    generator = torch.Generator().manual_seed(1)
    image = torch.rand(3, 9, 10, generator=generator)
    place = pixel_coordinates((9, 10)) + 4 * torch.randn(2, 9, 10, generator=generator)
    torch.testing.assert_close(
        interpolated(image, place, wrap=wrap), warp(image, place, "bilinear", wrap), atol=2e-6, rtol=0
    )
    torch.testing.assert_close(interpolated(image, pixel_coordinates((9, 10)), wrap=wrap), image, atol=2e-6, rtol=0)


def test_what_is_done_again_has_the_same_derivatives_and_keeps_nothing_between():
    generator = torch.Generator().manual_seed(2)
    one, other = (torch.rand(3, 4, generator=generator, dtype=torch.float64, requires_grad=True) for _ in range(2))
    made = 0

    def function(a, b):
        nonlocal made
        made += 1
        return (a * b).sin() + a

    plain = torch.autograd.grad(function(one, other).square().sum(), (one, other))
    made = 0
    value = again(function, one, other)
    assert made == 1
    assert torch.equal(value, function(one, other))
    both = torch.autograd.grad(value.square().sum(), (one, other))
    assert made == 3  # once more for the derivatives, and once above
    for a, b in zip(plain, both, strict=True):
        torch.testing.assert_close(a, b)
    velocity = 0.3 * torch.randn(3, 2, 6, 7, generator=generator, dtype=torch.float64)
    torch.autograd.gradcheck(lambda v: displaced(v)[-1], velocity.requires_grad_(), eps=1e-6, atol=1e-4)
    assert not again(function, one.detach(), other.detach()).requires_grad
