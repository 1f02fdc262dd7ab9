"""Coordinates carried along: exact where that is possible, never mixed across a seam, blind behind a mask."""

import math

import pytest
import torch
from torch import Tensor

import flow
from flow.animation.carrying.coordinates import carried
from flow.animation.carrying.copies import JUMP, rigid
from flow.warps import lookup, pixel_coordinates

SHAPE = (24, 30)


def still(x: float = 0.0, y: float = 0.0) -> Tensor:
    return torch.tensor([float(x), float(y)]).view(2, 1, 1).expand(2, *SHAPE).clone()


def scattered() -> Tensor:
    """Every pixel from somewhere else, between pixels."""
    return 90 * torch.rand(2, *SHAPE, generator=torch.Generator().manual_seed(1))


def copy_of(x: float, y: float) -> Tensor:
    """One copy of the exemplar, from (x, y) on."""
    return pixel_coordinates(SHAPE) + torch.tensor([x, y]).view(2, 1, 1)


def test_zero_flow_leaves_coordinates_bit_for_bit() -> None:
    assert torch.equal(carried(scattered(), lookup(still())), scattered())


def test_whole_pixel_shifts_are_exact_away_from_the_inflow() -> None:
    moved = carried(scattered(), lookup(still(3, -2)))
    assert torch.equal(moved[:, :-2, 3:], scattered()[:, 2:, :-3])


def test_what_flows_in_continues_the_nearest_copy_even_beyond_the_exemplar() -> None:
    moved = carried(copy_of(1.5, 40.25), lookup(still(4, 0)))
    assert torch.allclose(moved, copy_of(1.5 - 4, 40.25), atol=1e-5)
    assert float(moved.min()) < 0


def test_within_a_copy_coordinates_are_interpolated() -> None:
    """An affine copy carried along an affine flow is the affine map of both."""
    source = 0.9 * pixel_coordinates(SHAPE) + 5.3
    look = lookup(flow.rotation(1.0)(0, SHAPE))
    moved = carried(source, look)
    assert float((moved - (0.9 * look.coordinates + 5.3))[:, look.known].abs().max()) < 1e-4


@pytest.mark.parametrize("shift", [0.25, 0.5, 0.75])
def test_a_seam_is_not_interpolated_across(shift: float) -> None:
    source = copy_of(10.0, 20.0)
    source[:, :, 15:] = copy_of(60.0, 50.0)[:, :, 15:]
    moved = carried(source, lookup(still(shift, 0)))
    offset = moved - pixel_coordinates(SHAPE)
    from_left = torch.isclose(offset[0], torch.tensor(10.0 - shift), atol=1e-4)
    from_right = torch.isclose(offset[0], torch.tensor(60.0 - shift), atol=1e-4)
    assert bool((from_left ^ from_right).all())
    assert bool(from_left[:, :15].all())
    assert bool(from_right[:, 16:].all())


def test_copies_that_nearly_continue_each_other_are_one() -> None:
    source = copy_of(10.0, 20.0)
    source[0, :, 15:] += 0.9 * JUMP
    moved = carried(source, lookup(still(0.5, 0)))
    assert torch.allclose(moved[0, :, 15] - 15, torch.tensor(10.0 - 0.5 + 0.45 * JUMP), atol=1e-4)


def test_what_is_behind_a_mask_has_no_influence() -> None:
    mask = flow.disc_mask(SHAPE, (14.0, 12.0), 6.0)
    look = lookup(flow.around(flow.uniform(1.3), mask)(0, SHAPE), mask)
    source, other = copy_of(7.25, 3.5), copy_of(7.25, 3.5)
    other[:, ~mask] += 0.7  # close enough to count as the same copy
    third = torch.where(mask, source, math.nan)
    for hidden in (other, third):
        assert torch.equal(carried(hidden, look, mask), carried(source, look, mask))


def test_where_nothing_is_known_coordinates_stay() -> None:
    look = lookup(still(2, 0))._replace(known=torch.zeros(SHAPE, dtype=torch.bool))
    assert torch.equal(carried(scattered(), look), scattered())


@pytest.mark.parametrize("degrees", [50.0, 120.0, 180.0])
def test_a_turned_copy_is_carried_exactly(degrees: float) -> None:
    """By fractions of a pixel, a copy turned by any angle goes on as one, up to its seam, and beyond the border."""
    below, beside = (step.view(2, 1, 1) for step in rigid(torch.tensor(math.radians(degrees))))
    pixels = pixel_coordinates(SHAPE)

    def copy_at(x: float, y: float) -> Tensor:
        return (pixels[0] - x) * beside + (pixels[1] - y) * below + 50

    source = copy_at(0.0, 0.0)
    source[:, :, 14:] += 30
    moved, wanted = carried(source, lookup(still(2.3, -1.4))), copy_at(2.3, -1.4)
    assert torch.allclose(moved[:, :, :14], wanted[:, :, :14], atol=1e-4)
    assert torch.allclose(moved[:, :, 18:], wanted[:, :, 18:] + 30, atol=1e-4)
