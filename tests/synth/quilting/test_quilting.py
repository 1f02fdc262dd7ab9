"""Whole syntheses: what holds for every output, whatever the texture."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import torch
from dots import copied, texture
from torch import Tensor

from kwatra.base.errors import InputError
from synth.quilting import Overlay, QuiltSettings, merge, origins, quilt, quilt_video, seams_drawn
from synth.quilting.growth import Budget, fill, refine
from synth.quilting.synthesis import error_region, new_placer, new_sheet, sources_of
from synth.quilting.variants import rotated


@pytest.mark.parametrize("placement", ["random", "whole", "sub"])
@pytest.mark.parametrize("normalized", [False, True])
def test_every_pixel_is_a_copy_and_refining_never_raises_the_cost(placement: str, normalized: bool) -> None:
    exemplar = texture(2, 24, 28)
    settings = QuiltSettings(placement=placement, normalized=normalized, refine=15)
    result = quilt(exemplar, (40, 45), settings)
    torch.testing.assert_close(result.image, copied(result, exemplar), rtol=0, atol=0)
    assert all(after <= before for before, after in zip(result.history, result.history[1:], strict=False))
    assert result.cost == pytest.approx(result.history[-1])
    assert result.cost == pytest.approx(float(result.seams.sum(dtype=torch.float64)), rel=1e-5)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"tile": True},
        {"rotate": (90.0, 25.0), "mirror": True},
        {"normalized": True},
        {"scale": (0.7, 1.0), "perspective": True},
    ],
)
@pytest.mark.parametrize("shape", [(24, 28), (6, 12, 12)])
def test_remembered_seams_are_those_of_the_offsets_at_every_step(
    options: dict, shape: tuple[int, ...], recomputed_seams: Callable[[object], np.ndarray]
) -> None:
    settings = QuiltSettings(**options)
    sheet = new_sheet(sources_of(texture(2, *shape), settings), [n + 9 for n in shape], settings)
    placer = new_placer(sheet, settings, error_region(shape, settings.region))

    def check(what: str, part: float) -> None:
        np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)
        assert sheet.total == int(sheet.seams.sum(dtype=np.int64))

    fill(sheet, placer, None, check)
    refine(sheet, placer, Budget(8, 8), None, check)
    assert sheet.filled.all()


def test_a_checkerboard_is_continued_without_a_seam() -> None:
    board = ((torch.arange(32)[:, None] // 4 + torch.arange(32) // 4) % 2).float()[None]
    result = quilt(board, (64, 72), QuiltSettings(k=0.001))
    whole = ((torch.arange(64)[:, None] // 4 + torch.arange(72) // 4) % 2).float()
    assert result.cost == 0
    # The board may begin anywhere in its period.
    assert any(torch.equal(result.image[0], whole.roll((y, x), (0, 1))) for y in range(8) for x in range(8))


def test_a_tile_repeats_without_a_seam_of_its_own() -> None:
    exemplar = texture(1, 32, 32)
    tiled = quilt(exemplar, (48, 48), QuiltSettings(tile=True))
    cut = quilt(exemplar, (48, 48))
    wrap = [(r.image[:, 0] - r.image[:, -1]).abs().mean() for r in (tiled, cut)]
    inner = (tiled.image[:, 1:] - tiled.image[:, :-1]).abs().mean()
    assert wrap[0] < 2 * inner
    assert wrap[0] < wrap[1]


def test_a_tile_says_where_each_pixel_is_from() -> None:
    exemplar = texture(1, 24, 24)
    result = quilt(exemplar, (40, 40), QuiltSettings(tile=True, refine=5))
    torch.testing.assert_close(result.image, copied(result, exemplar), rtol=0, atol=0)


@pytest.mark.parametrize(("height", "width", "angle"), [(40, 60, 20), (60, 40, 20), (50, 50, 45), (30, 80, -70)])
def test_a_turned_variant_is_the_largest_upright_rectangle(height: int, width: int, angle: float) -> None:
    y, x = torch.meshgrid(torch.arange(height) * 1.0, torch.arange(width) * 1.0, indexing="ij")
    turned = rotated(torch.stack([x, y]), angle)
    high, wide = turned.shape[1:]
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    # Turned counterclockwise, what lay to the right lies further up; coordinates tell where each pixel is from.
    inner = turned[:, 3:-3, 3:-3]
    slopes = [inner[0].diff(dim=1).mean(), inner[1].diff(dim=1).mean()]
    assert slopes == [pytest.approx(cos, abs=0.01), pytest.approx(sin, abs=0.01)]
    fits = [
        h * w
        for h in range(1, 90)
        for w in range(1, 90)
        if w * abs(cos) + h * abs(sin) <= width and w * abs(sin) + h * abs(cos) <= height
    ]
    assert high * abs(sin) + wide * abs(cos) <= width
    assert high * abs(cos) + wide * abs(sin) <= height
    assert high * wide >= max(fits) - high - wide


def test_quarter_turns_move_pixels_only() -> None:
    exemplar = texture(2, 9, 12)
    torch.testing.assert_close(rotated(exemplar, 90), exemplar.rot90(1, (-2, -1)), rtol=0, atol=0)
    torch.testing.assert_close(rotated(exemplar, -180), exemplar.flip(-1, -2), rtol=0, atol=0)


def test_perspective_goes_from_small_to_large() -> None:
    settings = QuiltSettings(scale=(0.4, 0.5, 0.63, 0.8, 1.0), perspective=True, refine=5)
    source = quilt(texture(1, 48, 48), (96, 64), settings).source
    assert source[0].max() == 0
    assert source[-1].min() == 4
    means = source.float().mean(1)
    assert bool((means[8:] - means[:-8] >= -0.5).all())


def test_unused_offsets_only() -> None:
    settings = QuiltSettings(refine=30)
    sheet = new_sheet(sources_of(texture(1, 24, 24), settings), (40, 40), settings)
    placer = new_placer(sheet, settings, (6, 6))
    seen = set()
    for _ in range(40):
        patch = placer.choose(placer.regions.anywhere(), filling=True)
        assert patch is not None
        sheet.lay(patch)
        assert (patch.number, patch.shift) not in seen
        seen.add((patch.number, patch.shift))


def test_constant_colour_and_values_of_any_range() -> None:
    flat = quilt(torch.full((3, 16, 16), 0.3), (20, 20))
    assert bool((flat.image == np.float32(0.3)).all())
    assert flat.cost == 0
    exemplar = texture(1, 16, 16) * 1000 - 300
    assert set(quilt(exemplar, (24, 24)).image.unique().tolist()) <= set(exemplar.unique().tolist())


NUMBERS = {
    "doubles": lambda t: t.double(),
    "halves": lambda t: t.half(),
    "bytes": lambda t: t.byte(),
    "with derivatives": lambda t: t.clone().requires_grad_(),
}


@pytest.mark.parametrize("numbers", NUMBERS)
def test_the_same_values_give_the_same_bits_whatever_numbers_they_are(numbers: str) -> None:
    given, settings = (texture(1, 32, 32) * 9).round(), QuiltSettings(refine=2, rotate=(30.0,), scale=(0.8,))
    other = NUMBERS[numbers](given)
    one, same = (quilt(each, (40, 44), settings) for each in (given, other))
    assert torch.equal(one.image, same.image)
    assert (origins(one, [given], settings) == origins(one, [other], settings)).all()
    keep = torch.zeros(12, 12, dtype=torch.bool)
    keep[5, 5] = True
    laid = [merge(each, [Overlay(each[:, :12, :12], (8, 4), keep)]).image for each in (given, other)]
    assert torch.equal(*laid)
    clip = (texture(1, 6, 16, 16) * 9).round()
    films = [quilt_video(each, 6, mode="time").image for each in (clip, NUMBERS[numbers](clip))]
    assert torch.equal(*films)


def merged(keep: Tensor) -> Tensor:
    return merge(torch.zeros(1, 20, 30), [Overlay(torch.ones(1, 12, 12), (8, 4), keep)]).image


def test_merge_finds_the_known_seam() -> None:
    background, overlay = torch.zeros(1, 20, 30), torch.ones(1, 12, 12)
    overlay[:, :3], overlay[:, -3:], overlay[..., :3], overlay[..., -3:] = 0, 0, 0, 0
    keep = torch.zeros(12, 12, dtype=torch.bool)
    keep[5, 5] = True
    result = merge(background, [Overlay(overlay, (8, 4), keep)], QuiltSettings(normalized=False))
    assert result.cost == 0
    assert bool((result.image[:, 7:13, 11:17] == 1).all())
    assert float(result.image.sum()) == 36


def test_seams_are_drawn_in_red_and_elsewhere_nothing_changes() -> None:
    result = quilt(texture(3, 24, 24), (40, 40))
    drawn = seams_drawn(result)
    red = (drawn == torch.tensor([1.0, 0.1, 0.1])[:, None, None]).all(0)
    assert bool(red.any())
    torch.testing.assert_close(drawn[:, ~red], result.image.clamp(0, 1)[:, ~red])


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda: quilt(texture(1, 5, 5), (9, 9)), "smaller than the overlap"),
        (lambda: quilt(texture(1, 16, 16), (9, 9, 9)), "give 2 whole numbers of pixels"),
        (lambda: quilt(texture(1, 16, 16) / 0, (9, 9)), "NaN or infinite"),
        (lambda: quilt(texture(1, 16, 16), (5, 5), QuiltSettings(tile=True)), "cannot meet itself"),
        (lambda: quilt_video(texture(1, 1, 16, 16)), "one frame"),
        (lambda: quilt_video(texture(1, 3, 16, 16)), "at least 4"),
        (lambda: quilt_video(texture(1, 9, 16, 16), mode="time", loop=True, hold=10), "hold is 10"),
        (lambda: quilt_video(texture(1, 9, 16, 16), 5, mode="time", loop=True, hold=5), "needs more than that"),
        (lambda: quilt_video(texture(1, 9, 16, 16), 7.5, mode="time"), "frames is 7.5 but a video needs"),
        (lambda: quilt_video(texture(1, 16, 16)), r"must be \(C, T, H, W\)"),
        (lambda: QuiltSettings(placement="best"), "placement is 'best'"),
        (lambda: merged(torch.ones(1, 12, 12, dtype=torch.bool)), r"keep mask of overlay 1 has shape \(1, 12, 12\)"),
        (lambda: merged(torch.ones(12, 12)), "and type torch.float32; give booleans"),
        (lambda: merged(torch.ones(12, 13, dtype=torch.bool)), "is 13x12 but the overlay is 12x12"),
    ],
)
def test_bad_input_is_refused_with_one_sentence(call, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        call()
