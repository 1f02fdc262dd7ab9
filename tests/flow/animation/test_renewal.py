"""Renewal: every hole is filled from within the exemplar, and a pixel changes only where that lowers the energy."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from skimage import data
from torch import Tensor

import flow
from flow.animation.fusion import seam_cut
from flow.animation.renewal import Renewal
from flow.animation.settings import Renewing
from flow.animation.term import gradient_weight
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar, InputError
from kwatra.cut.minimum import FREE, KEEP, TAKE, VOID

SHAPE = (60, 64)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)
QUICK = Renewing(blocks=6, block=24, window=12, step=6, tones=0)


def brick(side: int = 96) -> Tensor:
    wall = data.brick()[: 2 * side, : 2 * side].astype(np.float32) / 255
    return torch.from_numpy(wall.reshape(side, 2, side, 2).mean((1, 3)))[None]


def copied(degrees: float = 0.0) -> Tensor:
    """Coordinates of one copy, turned about the frame's center."""
    center = torch.tensor([32.0, 30.0]).view(2, 1, 1)
    x, y = pixel_coordinates(SHAPE) - center
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return torch.stack([cos * x - sin * y, sin * x + cos * y]) + center + 16


def renewed(source: Tensor, inside: Tensor = WHOLE, settings: Renewing = QUICK, exemplar: Exemplar | None = None):
    renewal = Renewal(exemplar or Exemplar.of(brick()), SHAPE, settings)
    return renewal, *renewal(source, inside, torch.Generator().manual_seed(0))


def test_what_is_not_worn_is_left_bit_for_bit() -> None:
    _, source, image, report = renewed(copied())
    assert torch.equal(source, copied())
    assert torch.equal(image, brick()[:, 16:76, 16:80])
    assert report == {"texture": 0.0, "flow": 0.0, "renewed": 0.0}


def test_worn_texture_is_replaced_by_less_worn() -> None:
    renewal, source, image, report = renewed(copied(30))
    worn = renewal.read.picture(copied(30), WHOLE)
    changed = (source != copied(30)).any(0)
    assert report["texture"] > 0
    assert report["renewed"] == pytest.approx(float(changed.float().mean()), abs=1e-6)
    assert report["renewed"] > 0.1
    difference = ((renewal.read(source) - worn).square()[0] * changed).mean() / brick().var(correction=0)
    assert report["flow"] == pytest.approx(float(difference), rel=1e-3)
    before = float(renewal.wear(worn, copied(30), WHOLE).mean())
    for number in range(6):
        source, image, _ = renewal(source, WHOLE, torch.Generator().manual_seed(number))
    assert float(renewal.wear(image, source, WHOLE).mean()) < 0.85 * before


def test_a_copy_found_again_is_straightened_where_it_lies() -> None:
    """And stays the fraction of a pixel off that the flow has carried it."""
    place = copied() + torch.tensor([0.3, -0.4]).view(2, 1, 1)
    center = place[:, 30:31, 32:33]
    radius = (place - center).square().sum(0).sqrt()
    angle = torch.deg2rad(60 * (1 - radius / 9).clamp(min=0))
    x, y = place - center
    twisted = center + torch.stack([angle.cos() * x - angle.sin() * y, angle.sin() * x + angle.cos() * y])
    eager = replace(QUICK, tolerance=0.0, seam=0.2, usage=0.0)
    gravel = Exemplar.of(torch.from_numpy(data.gravel()[:96, :96] / 255).float()[None])
    _, source, _, report = renewed(twisted, settings=eager, exemplar=gravel)
    changed = (source != twisted).any(0)
    assert report["renewed"] > 0.02
    off = (source - place)[:, changed].square().sum(0).sqrt()
    assert float(off.max()) < 0.05


def test_the_image_is_what_its_coordinates_show() -> None:
    renewal, source, image, _ = renewed(copied(12))
    assert torch.equal(image, renewal.read.picture(source, WHOLE))


@pytest.mark.parametrize("weights", [Renewing(), Renewing(flow_weight=0.05, seam=0.2), Renewing(seam=2.0)])
def test_a_renewal_never_raises_the_energy(weights: Renewing) -> None:
    """Wear saved against change and seams, of one block, counted anew from what came out."""
    settings = replace(QUICK, flow_weight=weights.flow_weight, seam=weights.seam, blocks=1)
    renewal, source, image, _ = renewed(copied(30), settings=settings)
    old, variance = renewal.read.picture(copied(30), WHOLE), renewal.wear.variance
    take = (source != copied(30)).any(0)
    assert bool(take.any())
    wear = (renewal.wear(old, copied(30), WHOLE) - settings.tolerance).clamp(min=0)
    change = (image - old).square()[0]
    gained = (settings.flow_weight * gradient_weight(old, torch.ones(1, 1, 1)) * change / variance - wear)[take].sum()
    # only the seams' cheaper side is seen: what the block would have shown on the other one is not kept
    rough = settings.seam * (change / variance).sqrt()
    seams = sum(float(rough[take & other].sum()) for other in beside(~take))
    assert float(gained) + seams < 0


def beside(mask: Tensor) -> list[Tensor]:
    """A mask moved by one pixel each way: where a neighbor is in it."""
    padded = torch.nn.functional.pad(mask, (1, 1, 1, 1))
    return [padded[1:-1, :-2], padded[1:-1, 2:], padded[:-2, 1:-1], padded[2:, 1:-1]]


@pytest.mark.parametrize("seed", range(8))
def test_the_seam_cut_is_the_best_of_all_labelings(seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = torch.from_numpy(rng.choice([KEEP, TAKE, FREE, FREE, FREE, FREE, VOID], (3, 4)))
    rough = torch.from_numpy(rng.uniform(0, 0.3, (3, 4)))
    taking = torch.from_numpy(rng.uniform(-0.5, 0.4, (3, 4)))

    def energy(take: np.ndarray) -> float:
        cost = float(taking[torch.from_numpy(take) & (state == FREE)].sum())
        for y, x in itertools.product(range(3), range(4)):
            for v, u in ((y + 1, x), (y, x + 1)):
                if v < 3 and u < 4 and VOID not in (state[y, x], state[v, u]) and take[y, x] != take[v, u]:
                    cost += float(rough[y, x] + rough[v, u])
        return cost

    free = np.argwhere(state.numpy() == FREE)
    every = []
    for choice in itertools.product([False, True], repeat=len(free)):
        take = state.numpy() == TAKE
        take[tuple(free.T)] = choice
        every.append(energy(take))
    take = seam_cut(state, rough, taking)
    assert energy(take) == pytest.approx(min(every), abs=2e-3)
    assert bool(take[state.numpy() == TAKE].all())
    assert not take[(state.numpy() == KEEP) | (state.numpy() == VOID)].any()


def owned(exemplar: Exemplar, source: Tensor) -> Tensor:
    """Where all exemplar pixels between which a source lies belong to one image."""
    height, width = exemplar.shape
    x, y = source
    within = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    owners = [
        exemplar.owner[v.long().clamp(0, height - 1), u.long().clamp(0, width - 1)]
        for u in (x.floor(), x.ceil())
        for v in (y.floor(), y.ceil())
    ]
    return within & (torch.stack(owners) == owners[0]).all(0) & (owners[0] >= 0)


def test_every_hole_is_filled_from_within_the_exemplar() -> None:
    hole = torch.ones(96, 96, dtype=torch.bool)
    hole[30:44, 30:50] = False
    exemplar = Exemplar.of([brick(), brick(48)], masks=[hole, None])
    source = copied(8) - 25  # beyond the left and upper border
    source[:, 40:50, 10:30] = torch.tensor([37.0, 36.0]).view(2, 1, 1)  # in the hole
    source[:, :20, 50:] = torch.nan_to_num(copied()[:, :20, 50:] + 500)
    inside = flow.disc_mask(SHAPE, (40.0, 40.0), 9.0)
    assert not bool(owned(exemplar, source)[inside].all())
    renewal, filled, image, _ = renewed(source, inside, exemplar=exemplar)
    lost = inside & renewal.read.lost(source)
    assert bool(lost.any())
    assert bool(owned(exemplar, filled)[lost].all())
    assert not bool(renewal.read.lost(filled)[inside].any())
    assert torch.equal(filled[:, ~inside], source[:, ~inside])
    assert bool(image.isfinite().all())


def test_copies_a_little_beyond_the_border_wait_for_a_block() -> None:
    """Their last pixels pass for more; when some are farther out, all beyond the border are renewed with them."""
    settings = replace(QUICK, blocks=0)
    source = copied() - torch.tensor([18.0, 0.0]).view(2, 1, 1)  # 2 px beyond the left border
    _, after, image, _ = renewed(source, settings=settings)
    assert torch.equal(after, source)
    assert torch.equal(image[:, :, 0], brick()[:, 16:76, 0])
    source[:, 20:30] -= torch.tensor([1.0, 0.0]).view(2, 1, 1)
    _, after, _, _ = renewed(source, settings=settings)
    assert bool(owned(Exemplar.of(brick()), after)[20:30].all())
    assert bool(owned(Exemplar.of(brick()), after)[18:32, :12].all())


def test_an_empty_frame_is_filled_with_texture() -> None:
    renewal, source, image, report = renewed(torch.full((2, *SHAPE), -9.0))
    assert float(image.std()) > 0.6 * float(brick().std())
    assert float(renewal.wear(image, source, WHOLE).mean()) < 0.5
    assert report["renewed"] == 0  # new, not renewed


@pytest.mark.parametrize(("settings", "reach"), [(replace(QUICK, flow_weight=1e6), 0), (replace(QUICK, blocks=0), 24)])
def test_where_nothing_may_change_only_holes_do(settings: Renewing, reach: int) -> None:
    """Without blocks for worn texture, those that fill a hole may still renew what is beside it."""
    source = copied(12)
    source[:, :16, :16] = -9
    _, filled, image, report = renewed(source, settings=settings)
    kept = torch.ones(SHAPE, dtype=torch.bool)
    kept[: 17 + reach, : 17 + reach] = False  # beside the hole is a seam
    worn = flow.warp(brick(), copied(12), "lanczos").clamp(brick().min(), brick().max())
    assert float((image - worn)[:, kept].abs().max()) < 1e-3
    assert reach or report["flow"] < 1e-6
    assert bool(owned(Exemplar.of(brick()), filled)[:16, :16].all())


def test_what_is_shown_stays_within_the_exemplars_range_and_out_of_its_holes() -> None:
    hole = torch.ones(96, 96, dtype=torch.bool)
    hole[40:50, 40:50] = False
    exemplar = Exemplar.of(torch.where(hole, brick(), 9.0), masks=[hole])
    image = Renewal(exemplar, SHAPE, QUICK).read(copied(3.0) + 0.4)
    assert float(brick()[:, hole].min()) <= float(image.min())
    assert float(image.max()) <= float(brick()[:, hole].max())


def test_the_gradient_weight_is_half_plus_half_the_slope_over_its_mean() -> None:
    image = torch.zeros(2, 6, 8)
    image[0, :, 4:] = 1.0  # one step of 1 along x between columns 3 and 4, in the channel that counts 3/4
    weight = gradient_weight(image, torch.tensor([0.75, 0.25]).view(2, 1, 1))
    slope = torch.zeros(6, 8)
    slope[:, 3] = 0.75
    assert torch.allclose(weight, 0.5 + 0.5 * slope / slope.mean())
    assert float(weight.mean()) == pytest.approx(1.0)
    assert torch.equal(gradient_weight(0 * image, torch.ones(2, 1, 1) / 2), torch.full((6, 8), 0.5))


def test_settings_that_make_no_sense_are_refused() -> None:
    for wrong in ({"flow_weight": -1.0}, {"seam": -0.1}, {"inertia": -1.0}, {"blocks": -1}):
        with pytest.raises(InputError, match="has a negative weight or number of blocks; give 0 or more"):
            Renewing(**wrong)
    for wrong in ({"block": 1}, {"window": 1}, {"step": 0}):
        with pytest.raises(InputError, match="has a size below 2 px; give at least 2"):
            Renewing(**wrong)


def test_a_tone_shown_too_often_is_renewed() -> None:
    """A frame all from the exemplar's darker half is not worn, but out of proportion."""
    exemplar = torch.cat([0.5 * brick(), brick()], 2)
    source = copied()
    settings = replace(QUICK, usage=50.0, flow_weight=0.0, seam=0.0)
    _, after, _, _ = renewed(source, exemplar=Exemplar.of(exemplar), settings=settings)
    assert torch.equal(after, source)
    _, after, _, _ = renewed(source, exemplar=Exemplar.of(exemplar), settings=replace(settings, tones=2.0))
    assert 0.1 < float((after[0] >= 96).float().mean()) < 0.8
