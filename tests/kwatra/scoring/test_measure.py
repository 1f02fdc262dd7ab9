"""Figures on images whose right answer is known."""

import math

import pytest
import torch
import torch.nn.functional as F
from textures import gravel, noise
from torch import Tensor

from kwatra.base.errors import InputError
from kwatra.scoring.quality import (
    carried_scales,
    copy_map,
    coverage_energy,
    forward_energy,
    measure,
    sharpness,
    sliced_wasserstein,
)

DISTANCES = ("forward", "coverage", "wasserstein")


def blurred(image: Tensor) -> Tensor:
    return F.avg_pool2d(F.pad(image, (1, 1, 1, 1), mode="replicate"), 3, stride=1)


@pytest.mark.parametrize("image", [noise(3, 40, 52), gravel(64, shrunk=2)], ids=["noise", "gravel"])
def test_an_image_is_perfect_beside_itself(image: Tensor) -> None:
    figures = measure(image, image)
    assert [figures[name] for name in DISTANCES] == pytest.approx([0, 0, 0], abs=1e-6)
    assert (figures["sharpness"], figures["copy"]) == (1, 1)
    assert figures["use"] > 0.95
    assert figures["overall"] == pytest.approx(0, abs=1e-6)


def test_half_an_exemplar_is_plausible_but_covers_half() -> None:
    smooth, rough = noise(1, 64, 64).mul(0.1), noise(1, 64, 64, seed=1)
    figures = measure(rough.repeat(1, 1, 2), torch.cat((smooth, rough), 2))
    # Windows over the output's own join are the only new ones.
    assert figures["forward"] < 0.12
    assert figures["coverage"] > 0.4
    assert figures["wasserstein"] > 0.15
    assert forward_energy(rough, torch.cat((smooth, rough), 2)) == 0


def test_blur_lowers_sharpness_and_nothing_else_raises_it() -> None:
    image = gravel(64, shrunk=2)
    assert 0.2 < sharpness(blurred(image), image) < 0.8
    assert sharpness(2 * image, image) == pytest.approx(2)
    assert sharpness(1 - image, image) == pytest.approx(1)


def test_noise_raises_the_forward_distance_by_its_own_size() -> None:
    image = gravel(64, shrunk=2)
    louder = [image + level * noise(*image.shape).sub(0.5) for level in (0.0, 0.1, 0.3)]
    distances = [forward_energy(output, image) for output in louder]
    assert distances == sorted(distances)
    size = 0.1 / math.sqrt(12) / float(image.std(correction=0))
    assert distances[1] == pytest.approx(size, rel=0.15)


def test_the_roles_of_forward_and_coverage_are_exchanged_with_the_images() -> None:
    a, b = noise(2, 24, 30), noise(2, 30, 24, seed=1)
    unit = [float(image.flatten(1).var(1, correction=0).mean().sqrt()) for image in (a, b)]
    there, back = forward_energy(a, b) * unit[1], coverage_energy(b, a) * unit[0]
    assert there == pytest.approx(back, rel=1e-5)


@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("shift", [(0, 1), (1, 2), (3, 3)])
def test_a_shifted_crop_is_plausible_at_every_scale(scale: int, shift: tuple[int, int]) -> None:
    exemplar = gravel(72, shrunk=2)
    crop = exemplar[:, shift[0] : shift[0] + 64, shift[1] : shift[1] + 64]
    assert forward_energy(crop, exemplar, scale=scale) < 1e-5


def test_the_wasserstein_distance_of_a_constant_shift_is_known() -> None:
    image = noise(1, 40, 40)
    # The mean over unit directions v of |sum v| for windows of d values is sqrt(2 / pi).
    unit = float(image.std(correction=0))
    expected = 0.5 * math.sqrt(2 / math.pi) / unit
    assert sliced_wasserstein(image + 0.5, image) == pytest.approx(expected, rel=0.15)


def test_the_wasserstein_distance_does_not_see_where_windows_are() -> None:
    image = noise(1, 40, 40)
    assert sliced_wasserstein(image.roll((17, 11), (1, 2)), image) < 0.1


def test_the_wasserstein_distance_sees_what_the_nearest_windows_do_not() -> None:
    dark, light = noise(1, 40, 40), 3 + noise(1, 40, 40, seed=1)
    even, uneven = torch.cat((dark, light), 2), torch.cat((dark, light, light, light), 2)
    assert coverage_energy(uneven, even) < 0.01
    assert sliced_wasserstein(uneven, even) > 0.2


def test_tiles_are_copied_whole() -> None:
    tile = noise(3, 30, 34)
    copies = copy_map(tile.repeat(1, 2, 3), tile)
    assert copies.size == pytest.approx(1, rel=0.01)
    assert len(copies.region.unique()) == 6
    assert copies.offset[:, 5, 40].tolist() == [-34, 0]
    assert copies.offset[:, 35, 5].tolist() == [0, -30]


def test_a_patch_is_found_where_it_is_and_came_from() -> None:
    exemplars = [noise(1, 40, 40), noise(1, 40, 40, seed=1)]
    output = noise(1, 64, 64, seed=2)
    output[:, 10:30, 20:44] = exemplars[1][:, 5:25, 9:33]
    copies = copy_map(output, exemplars)
    expected = torch.zeros(64, 64, dtype=torch.bool)
    expected[10:30, 20:44] = True
    assert torch.equal(copies.region > 0, expected)
    assert torch.equal(copies.image, torch.where(expected, 1, -1))
    assert copies.offset[:, expected].unique(dim=1).flatten().tolist() == [-11, -5]
    assert copies.size == pytest.approx(480**2 / 64**2 / 3200)


def test_larger_regions_have_larger_numbers_and_take_what_two_cover() -> None:
    exemplar, output = noise(1, 60, 60), noise(1, 60, 60, seed=2)
    exemplar[:, :5, 40:] = exemplar[:, 45:50, 10:30]
    output[:, :30] = exemplar[:, 20:50]
    output[:, 25:45, 10:30] = exemplar[:, :20, 40:]
    expected = torch.zeros(60, 60, dtype=torch.long)
    expected[30:45, 10:30] = 1
    expected[:30] = 2
    assert torch.equal(copy_map(output, exemplar).region, expected)


def test_use_tells_one_place_from_all() -> None:
    exemplar = noise(1, 80, 80)
    corner = exemplar[:, :16, :16].repeat(1, 5, 5)
    assert copy_map(corner, exemplar).use < 0.8
    assert copy_map(exemplar, exemplar).use > 0.99


def test_rearranged_blocks_are_copies_of_their_own_size() -> None:
    exemplar = noise(1, 64, 64)
    blocks = exemplar.reshape(1, 2, 32, 2, 32).flip(1, 3).reshape(1, 64, 64)
    assert copy_map(blocks, exemplar).size == pytest.approx(0.25, rel=0.02)


@pytest.mark.parametrize("change", [0.0, 0.1])
def test_one_color_is_measured_in_its_own_units(change: float) -> None:
    exemplar = torch.full((3, 40, 32), 0.5) * torch.tensor([1.0, 0.5, 0.1])[:, None, None]
    figures = measure(exemplar + change, exemplar)
    assert figures["forward"] == pytest.approx(change, abs=1e-6)
    assert figures["coverage"] == pytest.approx(change, abs=1e-6)
    assert (figures["sharpness"], figures["copy"], figures["use"]) == (1, 0, 1)
    assert (figures["overall"] > 0) == (change > 0)


def test_figures_do_not_depend_on_units() -> None:
    output, exemplar = noise(1, 40, 40), noise(1, 40, 40, seed=1)
    assert measure(output * 255, exemplar * 255) == pytest.approx(measure(output, exemplar), rel=1e-3)


def test_a_video_scores_the_mean_of_its_frames() -> None:
    exemplar = noise(1, 24, 24)
    frames = [noise(1, 24, 24, seed=1), exemplar]
    figures = measure(torch.stack(frames, 1), exemplar)
    single = [measure(frame, exemplar) for frame in frames]
    for name, value in figures.items():
        assert value == pytest.approx((single[0][name] + single[1][name]) / 2)


def test_each_of_several_exemplars_is_plausible() -> None:
    exemplars = [noise(1, 30, 30), noise(1, 24, 40, seed=1)]
    for exemplar in exemplars:
        assert forward_energy(exemplar, exemplars) == 0
        assert coverage_energy(exemplar, exemplars) > 0.1


@pytest.mark.parametrize(("side", "scales"), [(7, (1,)), (16, (1,)), (28, (1, 2)), (56, (1, 2, 4))])
def test_small_images_drop_scales_they_cannot_carry(side: int, scales: tuple[int, ...]) -> None:
    image = noise(1, side, side + 3)
    assert carried_scales(image, noise(1, 64, 64)) == scales
    assert all(math.isfinite(value) for value in measure(image, noise(1, 64, 64)).values())
    assert measure(image, image)["overall"] == pytest.approx(0, abs=1e-6)


def test_figures_have_the_same_bits_for_any_number_of_threads() -> None:
    output, exemplar = noise(1, 120, 110), noise(1, 100, 120, seed=1)
    torch.set_num_threads(1)
    alone = measure(output, exemplar)
    torch.set_num_threads(2)
    together = measure(output, exemplar)
    assert torch.get_num_threads() == 2
    assert alone == together


def test_no_global_random_state_is_used_or_moved() -> None:
    image, other = noise(1, 60, 60), noise(1, 60, 60, seed=1)
    state = torch.random.get_rng_state()
    assert measure(image, other) == measure(image, other)
    assert torch.equal(torch.random.get_rng_state(), state)


def test_bad_input_is_named_with_its_cure() -> None:
    image = noise(1, 16, 16)
    cases = [
        (noise(1, 6, 16), image, "output is 16x6 pixels; .* need at least 7"),
        (image, noise(1, 16, 5), "exemplar is 5x16 pixels"),
        (noise(3, 16, 16), image, "exemplar has 1 channels and output has 3"),
        (image, image.div(0), "exemplar holds NaN or infinite values"),
        (image, (image * 255).byte(), r"exemplar is torch.uint8 of shape \(1, 16, 16\)"),
        (image[0], image, r"output is torch.float32 of shape \(16, 16\)"),
        (image, [], "exemplar is an empty list"),
    ]
    for output, exemplar, message in cases:
        with pytest.raises(InputError, match=message):
            measure(output, exemplar)
    with pytest.raises(InputError, match="at scale 4 need at least 28"):
        forward_energy(image, image, scale=4)
    with pytest.raises(InputError, match="scale is 0"):
        coverage_energy(image, image, scale=0)
    with pytest.raises(InputError, match="output has 2 frames"):
        copy_map(noise(1, 2, 16, 16), image)
