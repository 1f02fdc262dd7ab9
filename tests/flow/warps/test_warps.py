"""Inversion: what a forward flow carries somewhere is found there. Interpolation: exact where exactness is possible."""

import math

import pytest
import torch
from torch import Tensor

import flow
from flow.warps.warp import KERNELS, pixel_coordinates
from kwatra import InputError

SHAPE = (40, 52)


def still(x: float = 0.0, y: float = 0.0) -> Tensor:
    return torch.tensor([float(x), float(y)]).view(2, 1, 1).expand(2, *SHAPE).clone()


def picture(channels: int = 3) -> Tensor:
    return torch.rand(channels, *SHAPE, generator=torch.Generator().manual_seed(3))


def smooth(places: Tensor) -> Tensor:
    """An image known everywhere: (1, *S) at places (2, *S)."""
    return (torch.sin(places[0] / 7) + torch.cos(places[1] / 5))[None]


@pytest.mark.parametrize("mode", KERNELS)
def test_zero_flow_is_exactly_the_identity(mode: str) -> None:
    found = flow.lookup(still())
    assert torch.equal(found.coordinates, pixel_coordinates(SHAPE))
    assert bool(found.known.all())
    assert torch.equal(flow.warp(picture(), found.coordinates, mode), picture())


@pytest.mark.parametrize("mode", KERNELS)
def test_whole_pixel_shifts_are_exact_and_leave_holes_where_nothing_flows_in(mode: str) -> None:
    found = flow.lookup(still(3, -2))
    moved = flow.warp(picture(), found.coordinates, mode)
    assert torch.equal(moved[:, :-2, 3:], picture()[:, 2:, :-3])
    expected = torch.zeros(SHAPE, dtype=torch.bool)
    expected[:-2, 3:] = True
    assert torch.equal(found.known, expected)


@pytest.mark.parametrize("mode", KERNELS)
def test_a_periodic_frame_is_shifted_around(mode: str) -> None:
    found = flow.lookup(still(3, -2), wrap=True)
    assert bool(found.known.all())
    assert torch.equal(flow.warp(picture(), found.coordinates, mode, wrap=True), picture().roll((-2, 3), (1, 2)))


@pytest.mark.parametrize("name", ["rotation", "sink", "source", "saddle:30", "vortices:30", "stream", "noise:4"])
def test_lookup_inverts_the_forward_map(name: str) -> None:
    forward = flow.named(name, speed=1.5)(0.0, SHAPE)
    q, known = flow.lookup(forward)
    landed = q + flow.warp(forward, q, "bilinear")
    assert float((landed - pixel_coordinates(SHAPE))[:, known].abs().max()) < 1e-3
    assert bool(known[5:-5, 5:-5].all())


def test_lookup_of_an_affine_flow_is_its_closed_form() -> None:
    matrix = torch.tensor([[0.03, -0.05], [0.04, 0.02]])
    places = pixel_coordinates(SHAPE) - 20.0
    q, known = flow.lookup(torch.einsum("ij,jhw->ihw", matrix, places))
    truth = torch.einsum("ij,jhw->ihw", torch.linalg.inv(torch.eye(2) + matrix), places) + 20.0
    assert float((q - truth)[:, known].abs().max()) < 1e-3
    inside = ((truth >= 0) & (truth <= torch.tensor([51.0, 39.0]).view(2, 1, 1))).all(0)
    assert torch.equal(known, inside)


def test_reading_the_flow_at_the_target_would_be_wrong() -> None:
    """The true inverse is far closer to where things go than p - flow(p)."""
    forward = flow.noise(4.0, scale=20.0)(0.0, SHAPE)
    naive = pixel_coordinates(SHAPE) - forward
    q, known = flow.lookup(forward)
    wrong = (naive + flow.warp(forward, naive, "bilinear") - pixel_coordinates(SHAPE))[:, known].abs().max()
    right = (q + flow.warp(forward, q, "bilinear") - pixel_coordinates(SHAPE))[:, known].abs().max()
    assert float(wrong) > 0.5
    assert float(right) < 1e-2


def test_what_tears_apart_leaves_a_hole_and_what_collides_does_not() -> None:
    apart = still()
    apart[0, :, :26], apart[0, :, 26:] = -3, 3
    known = flow.lookup(apart).known
    assert not bool(known[:, 24:28].any())
    assert bool(known[:, :22].all())
    assert bool(known[:, 30:].all())
    together = flow.lookup(-apart)
    assert bool(together.known[:, 3:-3].all())
    assert float((together.coordinates - pixel_coordinates(SHAPE))[0].abs()[:, 3:-3].max()) < 3.01


def test_texture_comes_only_from_where_the_mask_has_some() -> None:
    mask = torch.ones(SHAPE, dtype=torch.bool)
    mask[10:20, 10:20] = False
    forward = still(4, 0)
    found = flow.lookup(forward, mask)
    shifted = torch.zeros(SHAPE, dtype=torch.bool)
    shifted[:, 4:] = mask[:, :-4]
    assert torch.equal(found.known, shifted)
    behind = torch.where(mask, forward, torch.nan)
    behind[:, ~mask] = 17.0
    again = flow.lookup(behind, mask)
    assert torch.equal(again.coordinates, found.coordinates)
    assert torch.equal(again.known, found.known)


def test_finer_kernels_lose_less() -> None:
    places = pixel_coordinates(SHAPE) + 0.37
    errors = [
        float((flow.warp(smooth(pixel_coordinates(SHAPE)), places, mode) - smooth(places))[:, 4:-4, 4:-4].abs().max())
        for mode in ("nearest", "bilinear", "bicubic", "lanczos")
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 2e-3
    assert errors[3] < 5e-3  # lanczos keeps fine detail rather than slopes
    stripes = torch.sin(places[0] * 2.2)
    kept = [float(flow.warp(torch.sin(pixel_coordinates(SHAPE)[:1] * 2.2), places, m)[0, 5:-5, 5:-5].std())
            for m in ("bilinear", "bicubic", "lanczos")]  # fmt: skip
    assert kept[0] < kept[1] < kept[2] < 1.05 * float(stripes.std())


@pytest.mark.parametrize("mode", ["bilinear", "bicubic"])
def test_slopes_are_read_exactly_between_pixels(mode: str) -> None:
    inside = pixel_coordinates((20, 30)) + 4.3
    assert torch.allclose(flow.warp(pixel_coordinates(SHAPE), inside, mode), inside, atol=1e-4)


def test_interpolation_is_that_of_its_kernel() -> None:
    def catmull_rom(d: float) -> float:
        d = abs(d)
        return 1.5 * d**3 - 2.5 * d**2 + 1 if d < 1 else -0.5 * d**3 + 2.5 * d**2 - 4 * d + 2 if d < 2 else 0.0

    image, (x, y) = picture(1), (17.3, 21.8)
    expected = sum(
        catmull_rom(x - column) * catmull_rom(y - row) * float(image[0, row, column])
        for row in range(19, 25)
        for column in range(14, 21)
    )
    read = float(flow.warp(image, torch.tensor([x, y]).view(2, 1)))
    assert math.isclose(read, expected, abs_tol=1e-5)


def test_large_images_are_read_in_pieces_that_fit() -> None:
    places = torch.rand(2, 300, 300, generator=torch.Generator().manual_seed(1)) * 30 + 4
    whole = flow.warp(picture(), places)
    for row in (0, 57, 299):
        assert torch.equal(whole[:, row], flow.warp(picture(), places[:, row]))


def test_unknown_modes_and_flows_are_refused() -> None:
    with pytest.raises(InputError, match="the interpolation is 'cubic'; give one of nearest, bilinear, bicubic, lanc"):
        flow.warp(picture(), pixel_coordinates(SHAPE), "cubic")
    with pytest.raises(InputError, match=r"beyond the 52x40 frame; give a lower speed"):
        flow.lookup(still(60, 0))
    with pytest.raises(InputError, match=r"2080 vectors that are NaN or infinite"):
        flow.lookup(still(math.nan, 0))
    with pytest.raises(InputError, match=r"a flow has shape \(3, 4, 4\)"):
        flow.lookup(torch.zeros(3, 4, 4))
    with pytest.raises(InputError, match=r"a mask has shape \(4, 4\)"):
        flow.lookup(still(), torch.ones(4, 4, dtype=torch.bool))
    with pytest.raises(InputError, match="a mask covers every pixel; it is True where texture belongs"):
        flow.lookup(still(), torch.zeros(SHAPE, dtype=torch.bool))


def test_unknown_values_become_those_of_the_nearest_known_pixel() -> None:
    values, known = picture(), torch.zeros(SHAPE, dtype=torch.bool)
    known[5, 5] = known[30, 40] = True
    values[:, 6, 6] = math.nan
    whole = flow.filled(values, known)
    assert torch.equal(whole[:, 8, 9], values[:, 5, 5])
    assert torch.equal(whole[:, 39, 51], values[:, 30, 40])
    assert bool(whole.isfinite().all())


@pytest.mark.parametrize("mode", KERNELS)
def test_reading_in_a_loop_is_reading_tensors_and_the_same_bits_for_any_number_of_threads(mode: str) -> None:
    places = torch.rand(2, 300, generator=torch.Generator().manual_seed(1)) * 70 - 10
    read = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        read.append(flow.warp(picture(), places, mode))
    assert torch.equal(read[0], read[1])
    assert torch.equal(read[0], read[2])
    slow = flow.warp(picture().requires_grad_(), places, mode)  # what a gradient is wanted of is not read in a loop
    assert slow.requires_grad
    assert torch.allclose(read[0], slow, atol=1e-5)


def test_places_that_are_no_numbers_or_far_away_do_no_harm() -> None:
    places = torch.tensor([[math.nan, math.inf, -1e30, 1e30], [3.0, 3.0, 3.0, 3.0]])
    read = flow.warp(picture(), places, "nearest")
    assert torch.equal(read[:, 2:], picture()[:, 3, [0, -1]])


def test_a_mask_that_is_changed_in_place_is_looked_at_again() -> None:
    known = torch.zeros(SHAPE, dtype=torch.bool)
    known[5, 5] = True
    assert torch.equal(flow.filled(picture(), known)[:, 39, 51], picture()[:, 5, 5])
    known[30, 40] = True
    assert torch.equal(flow.filled(picture(), known)[:, 39, 51], picture()[:, 30, 40])


def test_unknown_values_are_found_where_no_gradients_are_kept_too() -> None:
    with torch.inference_mode():
        known = torch.ones(40, 52, dtype=torch.bool)
        known[20:, 30:] = False
        found = flow.filled(picture(), known)
    assert torch.equal(found, flow.filled(picture(), known.clone()))
