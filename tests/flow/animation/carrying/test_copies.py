"""Copies: areas kept by turning, crumbs gone, seams softened by what the other copy has there."""

import math

import pytest
import torch
from torch import Tensor

import flow
from flow.animation.carrying.copies import (
    JUMP,
    angles,
    changes,
    distortion,
    parted,
    rigid,
    softened,
    tidied,
    turned,
    turns,
)
from flow.warps.warp import pixel_coordinates

SHAPE = (24, 30)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)


def copy_of(x: float, y: float) -> Tensor:
    """One copy of the exemplar, from (x, y) on."""
    return pixel_coordinates(SHAPE) + torch.tensor([x, y]).view(2, 1, 1)


def two_copies() -> Tensor:
    source = copy_of(10.0, 20.0)
    source[:, :, 15:] = copy_of(60.0, 50.0)[:, :, 15:]
    return source


def turned_copy(degrees: float, x: float, y: float) -> Tensor:
    """One copy turned in the exemplar, whose first pixel shows (x, y)."""
    below, beside = rigid(torch.tensor(math.radians(degrees)))
    across, down = pixel_coordinates(SHAPE)
    return torch.tensor([x, y]).view(2, 1, 1) + below.view(2, 1, 1) * down + beside.view(2, 1, 1) * across


@pytest.mark.parametrize("degrees", [0.0, 30.0, -100.0, 179.0])
def test_a_copy_turned_by_any_angle_is_one_copy(degrees: float) -> None:
    source = turned_copy(degrees, 60.0, 50.0)
    assert torch.allclose(angles(source), torch.tensor(math.radians(degrees)), atol=1e-4)
    assert all(bool(one.all()) and float(change.abs().max()) < 1e-4 for change, one in changes(source))
    assert torch.equal(tidied(source, WHOLE, WHOLE), source)
    assert float(distortion(source, turned(source)).max()) < 1e-6


def test_crumbs_join_a_turned_copy_where_it_goes_on() -> None:
    source = turned_copy(130.0, 60.0, 50.0)
    frayed = source.clone()
    frayed[:, 5, 4] = torch.tensor([5.0, 90.0])
    assert torch.allclose(tidied(frayed, WHOLE, WHOLE), source, atol=1e-4)


def test_a_seam_shows_a_turned_copy_where_it_goes_on() -> None:
    source = turned_copy(75.0, 60.0, 50.0)
    on = source[:, :, 15].clone()
    source[:, :, 15:] = turned_copy(-160.0, 20.0, 30.0)[:, :, 15:]
    seen: list[Tensor] = []
    softened(torch.zeros(1, *SHAPE), source, WHOLE, lambda at: seen.append(at) or torch.zeros(1, at.shape[1]))  # type: ignore[func-returns-value]
    off = torch.cat(seen, 1)[:, None] - on[:, :, None]
    assert float(off.square().sum(0).amin(1).max()) < 1e-8


def test_an_offset_that_jumps_is_another_copy() -> None:
    (_, below), (across, right) = changes(two_copies())
    assert bool(below.all())
    assert bool(right[:, :14].all() & right[:, 15:].all() & ~right[:, 14].any())
    assert torch.equal(across[:, 0, 14], torch.tensor([50.0, 30.0]))
    ahead = copy_of(0.0, 0.0)
    ahead[0, :, 15:] += 0.99 * JUMP
    assert bool(changes(ahead)[1][1].all())


def test_turning_and_shearing_keep_areas_and_enlarging_does_not() -> None:
    x, y = pixel_coordinates(SHAPE)
    turn, upright = math.radians(9), rigid(torch.zeros(SHAPE))[1]
    lying = torch.stack([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y])
    assert float(distortion(lying, turned(lying))[:-1, :-1].abs().max()) < 1e-8
    assert float(distortion(torch.stack([x + 0.3 * y, y]), upright)[:-1, :-1].abs().max()) < 1e-8
    enlarged = distortion(torch.stack([0.8 * x, 0.9 * y]), upright)
    assert torch.allclose(enlarged[:-1, :-1], torch.tensor((0.72 - 1) ** 2), atol=1e-4)
    assert float(distortion(2.0 * pixel_coordinates(SHAPE), upright).max()) == 1


def test_a_seam_is_no_distortion() -> None:
    assert float(distortion(two_copies(), rigid(torch.zeros(SHAPE))[1]).abs().max()) < 1e-8


def test_directions_turn_with_a_copy_and_a_seam_turns_none() -> None:
    angle = math.radians(12)
    turn = torch.tensor([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    source = torch.einsum("ij,jhw->ihw", 1.2 * turn.T, pixel_coordinates((20, 30), torch.device("cpu")))
    assert torch.allclose(turns(source), turn.view(2, 2, 1, 1).expand(2, 2, 20, 30), atol=1e-5)
    assert torch.equal(turns(two_copies()), torch.eye(2).view(2, 2, 1, 1).expand(2, 2, *two_copies().shape[1:]))


def test_crumbs_join_the_copy_around_them() -> None:
    source = two_copies()
    frayed = source.clone()
    frayed[:, 5, 4] = copy_of(33.0, 90.0)[:, 5, 4]
    frayed[:, 11, 20:22] = copy_of(5.0, 6.0)[:, 11, 20:22]
    assert torch.equal(tidied(frayed, WHOLE, WHOLE), source)


def test_what_is_no_crumb_or_not_free_is_left_bit_for_bit() -> None:
    source = two_copies()
    source[:, 8:11, 20:23] = copy_of(5.0, 6.0)[:, 8:11, 20:23]
    assert torch.equal(tidied(source, WHOLE, WHOLE), source)
    frayed = source.clone()
    frayed[:, 5, 4] = copy_of(33.0, 90.0)[:, 5, 4]
    assert torch.equal(tidied(frayed, ~WHOLE, WHOLE), frayed)


def test_what_lies_outside_draws_no_crumb_in() -> None:
    """A lone pixel of its own copy, with texture on one side only and one other copy all over the outside."""
    source = two_copies()
    source[:, 6:, :] = copy_of(33.0, 90.0)[:, 6:, :]
    source[:, 5, 4] = copy_of(80.0, 7.0)[:, 5, 4]
    inside = WHOLE.clone()
    inside[6:] = False
    after = tidied(source, inside, inside)
    assert torch.equal(after[:, 5, 4], copy_of(10.0, 20.0)[:, 5, 4])
    source[:, :5] = copy_of(60.0, 50.0)[:, :5]
    lone = torch.zeros_like(WHOLE)
    lone[5, 4] = True
    assert torch.equal(tidied(source, lone, lone), source)


def test_a_seam_shows_an_eighth_of_each_other_copy_beside_it() -> None:
    source, exemplar = two_copies(), torch.rand(1, 90, 100, generator=torch.Generator().manual_seed(0))

    def read(place: Tensor) -> Tensor:
        return flow.warp(exemplar, place, "bilinear")

    image = read(source)
    soft = softened(image, source, WHOLE, read)
    away = torch.ones_like(WHOLE)
    away[:, 14:16] = False
    assert torch.equal(soft[:, away], image[:, away])
    right = read(copy_of(60.0, 50.0))[:, :, 14]
    left = read(copy_of(10.0, 20.0))[:, :, 15]
    assert torch.allclose(soft[:, :, 14], 0.875 * image[:, :, 14] + 0.125 * right)
    assert torch.allclose(soft[:, :, 15], 0.875 * image[:, :, 15] + 0.125 * left)
    inside = WHOLE.clone()
    inside[:, 15:] = False
    assert torch.equal(softened(image, source, inside, read), image)


def test_crumbs_are_looked_for_again_around_those_that_have_joined() -> None:
    chance = torch.Generator().manual_seed(0)
    one, other = copy_of(10.0, 20.0), copy_of(60.0, 50.0)
    frayed = torch.where(torch.rand(SHAPE, generator=chance) < 0.3, one, other)
    tidy = tidied(frayed, WHOLE, WHOLE)
    assert not torch.equal(tidy, frayed)
    assert torch.equal(tidied(tidy, WHOLE, WHOLE), tidy)


@pytest.mark.parametrize("degrees", [0.0, 35.0, -120.0])
def test_what_copies_change_by_to_the_right_is_the_direction_of_their_angle(degrees: float) -> None:
    angle = torch.full(SHAPE, math.radians(degrees))
    expected = torch.stack([angle.cos(), angle.sin()])
    torch.testing.assert_close(turned(turned_copy(degrees, 60.0, 50.0)), expected, atol=1e-4, rtol=0)


def test_pixels_are_parted_where_the_copy_beside_goes_on_to_another_place() -> None:
    source = pixel_coordinates((6, 8)).clone()
    source[:, :, 5:] += torch.tensor([20.0, 3.0]).view(2, 1, 1)
    inside = torch.ones(6, 8, dtype=torch.bool)
    inside[0] = False
    (left, above), goes_on = parted(source, inside, turned(source, inside), [(0, -1), (-1, 0)])
    expected = torch.zeros(6, 8, dtype=torch.bool)
    expected[1:, 5] = True
    assert torch.equal(left, expected)
    assert not bool(above.any())
    assert torch.equal(goes_on[0, :, 2, 5], torch.tensor([5.0, 2.0]))
