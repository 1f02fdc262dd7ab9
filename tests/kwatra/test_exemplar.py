import pytest
import torch

from kwatra import Exemplar, InputError


def image(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed))


def test_windows_never_mix_images():
    exemplar = Exemplar.of([image(1, 20, 30), image(1, 12, 9)])
    valid = exemplar.corners((8, 8))
    assert int(valid.sum()) == 13 * 23 + 5 * 2


def test_masked_pixels_are_in_no_window():
    mask = torch.ones(20, 20, dtype=torch.bool)
    mask[10, 10] = False
    valid = Exemplar.of([image(1, 20, 20)], masks=[mask]).corners((8, 8))
    assert not bool(valid[3:11, 3:11].any())
    assert int(valid.sum()) == 13 * 13 - 8 * 8


@pytest.mark.parametrize("options", [{"mirror": True}, {"rotate": (90, 180)}, {"mirror": True, "rotate": (270,)}])
def test_origin_leads_back_to_the_pixel_for_exact_copies(options):
    pictures = [image(3, 16, 20), image(3, 11, 30, seed=1)]
    exemplar = Exemplar.of(pictures, **options)
    owned = exemplar.owner >= 0
    number, row, column = exemplar.origin[:, owned]
    colors = exemplar.canvas[:, owned]
    for k, picture in enumerate(pictures):
        assert torch.equal(colors[:, number == k], picture[:, row[number == k], column[number == k]])


def test_rotation_is_counterclockwise():
    arrow = torch.zeros(1, 41, 41)
    arrow[:, 20, 30] = 1.0  # to the right of the middle
    exemplar = Exemplar.of(arrow, rotate=(45,))
    place = (exemplar.owner == 1).nonzero()
    center = (place.amin(0) + place.amax(0)) / 2
    turned = torch.where(exemplar.owner == 1, exemplar.canvas[0], -1.0)
    spot = (turned == turned.max()).nonzero()[0]
    assert (spot - center).tolist() == pytest.approx([-7, 7], abs=1.6)  # up and to the right


def test_scaled_variant_has_the_scaled_size_and_the_same_mean():
    smooth = torch.linspace(0, 1, 40).expand(1, 40, 40).contiguous()
    exemplar = Exemplar.of(smooth, scale=(0.5,))
    copy = exemplar.canvas[0][exemplar.owner == 1]
    assert len(copy) == pytest.approx(20 * 20, rel=0.25)
    assert float(copy.mean()) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(("side", "factor"), [(8, 0.1), (4, 0.2), (12, 0.1)])
def test_a_variant_smaller_than_a_pixel_is_one(side, factor):
    picture = image(1, side, side)
    exemplar = Exemplar.of(picture, scale=(factor,))
    copy = exemplar.canvas[0, side + 1 :][exemplar.owner[side + 1 :] == 1]
    assert copy.tolist() == pytest.approx([float(picture.mean())])


VARIANTS = [
    {"rotate": (30,)},
    {"rotate": (45,)},
    {"scale": (1.5,)},
    {"scale": (0.7,)},
    {"mirror": True, "rotate": (20,)},
]


@pytest.mark.parametrize("options", VARIANTS)
def test_what_a_hole_holds_is_in_no_variant(options):
    mask = torch.ones(40, 44, dtype=torch.bool)
    mask[15:25, 12:30] = False
    dark = image(2, 40, 44)
    light = torch.where(mask, dark, 5.0)
    one, other = (Exemplar.of(each, masks=[mask], **options) for each in (dark, light))
    assert torch.equal(one.owner, other.owner)
    assert torch.equal(one.canvas[:, one.owner > 0], other.canvas[:, one.owner > 0])


@pytest.mark.parametrize("options", VARIANTS)
def test_nothing_beyond_the_border_is_in_a_variant(options):
    flat = torch.full((1, 41, 43), 0.5)
    flat[:, 20, 20:22] = torch.tensor([0.0, 1.0])  # so that colors may overshoot
    exemplar = Exemplar.of(flat, **options)
    row, column = exemplar.origin[1:]
    outer = (exemplar.owner > 0) & ((row - 20).abs().maximum((column - 20).abs()) > 9)
    assert torch.allclose(exemplar.canvas[0, outer], torch.tensor(0.5), atol=1e-5)


def test_coarser_averages_blocks_and_drops_broken_ones():
    picture = image(2, 17, 12)
    coarse = Exemplar.of(picture).coarser((4, 4))
    assert torch.allclose(coarse.canvas, torch.nn.functional.avg_pool2d(picture, 4))
    mask = torch.ones(17, 12, dtype=torch.bool)
    mask[5, 5] = False
    owner = Exemplar.of([picture], masks=[mask]).coarser((4, 4)).owner
    assert owner[1, 1] == -1
    assert int((owner == 0).sum()) == 4 * 3 - 1


def test_an_exemplar_is_halved_until_it_has_so_many_pixels_and_what_is_coarser_is_kept():
    exemplar = Exemplar.of(image(2, 256, 280))
    assert exemplar.halved_to(256 * 280) == (exemplar, 1)
    for pixels, factor in ((256 * 280 - 1, 2), (128 * 140, 2), (128 * 140 - 1, 4), (32 * 35, 8), (1, 32)):
        seen, much = exemplar.halved_to(pixels)
        assert much == factor
        assert seen is exemplar.coarser((factor, factor))
        assert torch.equal(seen.canvas, torch.nn.functional.avg_pool2d(exemplar.canvas, factor))
    assert Exemplar.of(image(2, 127, 300)).halved_to(1)[1] == 8  # a strip stays wide enough
    video = Exemplar.of(image(2, 6, 40, 50))
    assert video.halved_to(1) == (video, 1)


def test_extent_is_the_largest_image_not_the_canvas():
    assert Exemplar.of([image(1, 20, 30), image(1, 25, 9)]).extent == (25, 30)


def test_variants_are_no_larger_than_what_was_given():
    varied = Exemplar.of(image(1, 24, 32), mirror=True, rotate=(30, 90), scale=(0.5, 2.0))
    assert varied.extent == (24, 32)
    assert varied.coarser((4, 4)).extent == (6, 8)


@pytest.mark.parametrize(
    ("images", "options", "message"),
    [
        ([], {}, "no exemplar was given"),
        ([torch.zeros(3, 0, 5)], {}, "not empty"),
        ([torch.zeros(8, 8)], {}, r"images are \(C, H, W\)"),
        ([torch.zeros(1, 8, 8), torch.zeros(3, 8, 8)], {}, "1 and 3 channels"),
        ([torch.full((1, 8, 8), torch.nan)], {}, "NaN or infinite"),
        ([torch.zeros(1, 8, 8)], {"masks": [torch.ones(7, 8, dtype=torch.bool)]}, "must be the same"),
        ([torch.zeros(1, 8, 8)], {"weights": [-1.0]}, "finite number >= 0"),
        ([torch.zeros(1, 8, 8)], {"scale": [0.0]}, "scales are 0.1 to 10"),
        ([torch.zeros(1, 8, 8)], {"rotate": 30}, r"variants are turned by 30; give several numbers, \(30,\) for one"),
    ],
)
def test_unusable_input_is_said_in_a_sentence(images, options, message):
    with pytest.raises(InputError, match=message):
        Exemplar.of(images, **options)


def test_masks_that_leave_nothing_or_are_no_booleans_are_refused():
    with pytest.raises(InputError, match="leave nothing to copy from"):
        Exemplar.of(image(1, 12, 12), masks=[torch.zeros(12, 12, dtype=torch.bool)])
    with pytest.raises(InputError, match=r"mask holds torch\.float32; give booleans"):
        Exemplar.of(image(1, 12, 12), masks=[torch.ones(12, 12)])


@pytest.mark.parametrize("ways", [{}, {"mirror": True, "rotate": (30.0,)}])
def test_alpha_is_the_last_of_two_or_four_channels_by_which_others_were_multiplied(ways):
    alpha = (image(1, 16, 20, seed=1) * 2).clamp(0, 1)
    for channels in (1, 3):
        seen = torch.cat([image(channels, 16, 20) * alpha, alpha])
        found = Exemplar.of(seen, **ways).alpha
        assert found is not None
        assert torch.equal(found[:16, :20], alpha[0])
    straight = torch.cat([image(3, 16, 20), alpha])
    for other in (straight, seen[:3], torch.cat([seen, alpha])):
        assert Exemplar.of(other, **ways).alpha is None


def test_alpha_is_not_looked_for_in_holes():
    alpha = image(1, 16, 20, seed=1)
    seen = torch.cat([image(3, 16, 20) * alpha, alpha])
    seen[0, 4, 5] = 1.0
    whole = torch.ones(16, 20, dtype=torch.bool)
    assert Exemplar.of(seen).alpha is None
    whole[4, 5] = False
    assert Exemplar.of(seen, masks=[whole]).alpha is not None


def test_variances_are_those_of_what_may_be_copied_and_together_they_count_by_weight():
    seen = image(3, 20, 24)
    mask = torch.rand(20, 24, generator=torch.Generator().manual_seed(1)) < 0.6
    exemplar = Exemplar.of([seen], masks=[mask], weights=torch.tensor([1.0, 0.0, 3.0]))
    expected = seen[:, mask].double().var(1, correction=0)
    assert torch.allclose(exemplar.variances.double(), expected, rtol=1e-5)
    assert exemplar.variance == pytest.approx(float(expected[0] + 3 * expected[2]) / 4, rel=1e-5)
