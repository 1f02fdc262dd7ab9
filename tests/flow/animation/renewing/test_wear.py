"""Wear: nothing for copies, more the more a copy is turned, stretched or replaced by something else."""

import itertools
import math

import pytest
import torch
import torch.nn.functional as F
from scipy import ndimage
from torch import Tensor

import flow
from flow.animation.film.film import Film
from flow.animation.renewing.wear import Wear
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar
from kwatra.windows.metric import falloff

SHAPE = (36, 40)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)
AT_THE_BORDER = 3e-3
"""What the blur costs there: beyond the border it repeats the border's pixels."""


def stones(side: int = 64, seed: int = 0) -> Tensor:
    noise = torch.rand(3, side, side, generator=torch.Generator().manual_seed(seed))
    return F.avg_pool2d(F.pad(noise[None], (2, 2, 2, 2), mode="reflect"), 5, 1)[0]


def turned(degrees: float, size: float = 1.0) -> Tensor:
    """Coordinates of a copy turned about the frame's center."""
    center = torch.tensor([20.0, 18.0]).view(2, 1, 1)
    x, y = pixel_coordinates(SHAPE) - center
    cos, sin = size * math.cos(math.radians(degrees)), size * math.sin(math.radians(degrees))
    return torch.stack([cos * x - sin * y, sin * x + cos * y]) + center + 12


def wear_of(
    exemplar: Exemplar | Tensor, source: Tensor, area: float = 0.0, inside: Tensor = WHOLE, turn: bool = False
) -> Tensor:
    exemplar = Exemplar.of(exemplar) if isinstance(exemplar, Tensor) else exemplar
    image = flow.warp(exemplar.canvas, source, "lanczos")
    return Wear(Film.of(exemplar, turn=turn), SHAPE, 16, 4, area)(image, source, inside)


def test_a_verbatim_copy_is_not_worn() -> None:
    wear = wear_of(stones(), turned(0), area=1.0)
    assert float(wear.max()) < AT_THE_BORDER
    assert float(wear[18, 20]) < 1e-6


def test_a_fraction_of_a_pixel_is_hardly_wear() -> None:
    assert float(wear_of(stones(), turned(0) + 0.5).max()) < 0.06


def test_a_copy_from_elsewhere_than_its_coordinates_say_is_found() -> None:
    image = flow.warp(stones(), turned(0))
    lying = turned(0).flip(1)
    assert float(Wear(Film.of(Exemplar.of(stones())), SHAPE, 16, 4, 0.0)(image, lying, WHOLE).max()) < AT_THE_BORDER


def test_wear_grows_as_a_copy_turns() -> None:
    means = [float(wear_of(stones(), turned(angle)).mean()) for angle in (0, 4, 8, 16)]
    assert means[0] < AT_THE_BORDER / 4
    assert all(2 * before < after for before, after in itertools.pairwise(means))
    assert means[1] > 0.005


def test_what_may_turn_is_not_worn_by_that_and_bent_as_ever() -> None:
    for angle in (8, 16, 100, 180):
        may, may_not = (float(wear_of(stones(), turned(angle), turn=turn).mean()) for turn in (True, False))
        assert may < 0.005 < 0.1 * may_not
    assert float(wear_of(stones(), turned(16, 1.3), 1.0, turn=True).mean()) > 0.1


def test_wear_of_a_part_is_that_of_the_whole_where_copies_may_turn() -> None:
    wear = Wear(Film.of(Exemplar.of(stones()), turn=True), SHAPE, 16, 4, 0.5)
    source = turned(40)
    before = wear.of(flow.warp(stones(), source, "lanczos"), source)
    source[:, 6:14, 9:20] = turned(-70)[:, 6:14, 9:20]
    image = flow.warp(stones(), source, "lanczos")
    whole, part = wear.of(image, source), wear.after(before, image, source, (slice(6, 14), slice(9, 20)))
    assert torch.allclose(part.wear, whole.wear, atol=1e-5)
    assert torch.equal(part.angle, whole.angle)


def test_wear_is_where_the_wrong_pixels_are() -> None:
    image = flow.warp(stones(), turned(0))
    image[:, 8:14, 8:14] = stones(seed=9)[:, :6, :6]
    wear = Wear(Film.of(Exemplar.of(stones())), SHAPE, 16, 4, 0.0)(image, turned(0), WHOLE)
    assert float(wear[11, 11]) > 0.1
    assert float(wear[:, 32:].max()) < AT_THE_BORDER


def test_something_unrelated_is_as_worn_as_its_nearest_window_is_far() -> None:
    """Brute force over all windows of the blurred exemplar, for a picture of one color."""
    image = torch.full((3, *SHAPE), 0.8)
    blurred = torch.from_numpy(ndimage.gaussian_filter(stones().numpy(), 1.0, mode="nearest", axes=(1, 2)))
    weight = falloff((8, 8)) / 3
    least = F.conv2d((blurred[None] - 0.8).square(), weight.expand(1, 3, 8, 8)).min()
    variance = stones().var((1, 2), correction=0).mean()
    wear = Wear(Film.of(Exemplar.of(stones())), SHAPE, 8, 4, 0.0)(image, turned(0), WHOLE)
    assert torch.allclose(wear, least / variance, rtol=1e-3)


def test_showing_too_little_of_the_exemplar_is_wear() -> None:
    enlarged = turned(0, 0.9)
    added = wear_of(stones(), enlarged, area=3.0) - wear_of(stones(), enlarged)
    assert torch.allclose(added[:-1, :-1], torch.tensor(3.0 * (0.9**2 - 1) ** 2), atol=1e-4)


def test_there_is_no_wear_outside() -> None:
    inside = flow.disc_mask(SHAPE, (18.0, 20.0), 9.0)
    assert float(wear_of(stones(), turned(20), 1.0, inside)[~inside].abs().max()) == 0


def test_units_are_the_exemplars_variance() -> None:
    bright = wear_of(stones(), turned(10))
    dark = wear_of(0.1 * stones() + 0.3, turned(10))
    assert torch.allclose(bright, dark, rtol=0.02, atol=1e-3)


def test_channels_count_by_their_weight() -> None:
    spoiled = flow.warp(stones(), turned(0))
    spoiled[2] = 0.5
    source = Exemplar.of(stones(), weights=[1.0, 1.0, 0.0])
    assert float(Wear(Film.of(source), SHAPE, 16, 4, 0.0)(spoiled, turned(0), WHOLE).max()) < AT_THE_BORDER
    assert float(Wear(Film.of(Exemplar.of(stones())), SHAPE, 16, 4, 0.0)(spoiled, turned(0), WHOLE).mean()) > 0.1


def test_what_a_hole_of_the_exemplar_holds_has_no_influence() -> None:
    hole = torch.ones(64, 64, dtype=torch.bool)
    hole[20:30, 30:42] = False
    image = flow.warp(stones(), turned(9))
    figures = [
        Wear(Film.of(Exemplar.of(torch.where(hole, stones(), value), masks=[hole])), SHAPE, 16, 4, 0.1)(
            image, turned(9), WHOLE
        )
        for value in (0.0, 1.0)
    ]
    assert torch.equal(*figures)


@pytest.mark.parametrize("side", [5, 23])
def test_windows_fit_into_small_exemplars_and_stay_few(side: int) -> None:
    wear = Wear(Film.of(Exemplar.of(stones(side))), SHAPE, 24, 6, 0.0)
    assert wear.grid.width[0] <= side
    assert len(wear.grid) <= 8 * 9
    assert bool(wear(torch.rand(3, *SHAPE), turned(0), WHOLE).isfinite().all())


def test_an_exemplar_of_one_color_wears_only_where_another_shows() -> None:
    plain = torch.full((1, 30, 30), 0.4)
    wear = Wear(Film.of(Exemplar.of(plain)), SHAPE, 16, 4, 0.0)
    assert float(wear(torch.full((1, *SHAPE), 0.4), turned(0), WHOLE).max()) < 1e-3
    assert float(wear(torch.full((1, *SHAPE), 0.5), turned(0), WHOLE).min()) > 1


def test_wear_after_a_change_is_what_it_is_anew() -> None:
    wear = Wear(Film.of(Exemplar.of(stones())), SHAPE, 16, 4, 0.5)
    source = turned(6)
    image = flow.warp(stones(), source, "lanczos")
    worn = wear.of(image, source)
    for spot in ((slice(0, 9), slice(0, 12)), (slice(14, 22), slice(30, 40)), (slice(20, 21), slice(20, 21))):
        source, image = source.clone(), image.clone()
        here = (slice(None), *spot)
        source[here] = turned(0)[here] + 3
        image[here] = flow.warp(stones(), source[here], "lanczos")
        before, worn = worn.wear, wear.after(worn, image, source, spot)
        assert torch.allclose(worn.wear, wear.of(image, source).wear, atol=1e-5)
        changed = ((worn.wear - before).abs() > 1e-7).nonzero()
        for axis, part in enumerate(wear.reach(spot)):
            assert int(changed[:, axis].min()) >= part.start
            assert int(changed[:, axis].max()) < part.stop
