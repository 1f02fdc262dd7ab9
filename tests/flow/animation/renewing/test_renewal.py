"""Renewal: every hole is filled from within the exemplar, and a pixel changes only where that lowers the energy."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from skimage import data
from torch import Tensor

import flow
from flow.animation.film.film import Film
from flow.animation.renewing.needs import starts
from flow.animation.renewing.renewal import Renewal
from flow.animation.renewing.stock import COUNTS
from flow.animation.renewing.wear import Wear, Worn
from flow.animation.settings import Renewing
from flow.animation.term import gradient_weight
from flow.warps.warp import pixel_coordinates
from kwatra import Exemplar, InputError

pytestmark = pytest.mark.usefixtures("nothing_hides_seams")
SHAPE = (60, 64)
WHOLE = torch.ones(SHAPE, dtype=torch.bool)
QUICK = Renewing(blocks=6, block=24, window=12, step=6, tones=0, flow_weight=0.025)


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
    renewal = Renewal(Film.of(exemplar or Exemplar.of(brick()), turn=False), SHAPE, settings)
    source, image, _, report = renewal(source, inside, torch.Generator().manual_seed(0))
    return renewal, source, image, report


def test_what_is_not_worn_is_left_bit_for_bit() -> None:
    _, source, image, report = renewed(copied())
    assert torch.equal(source, copied())
    assert torch.equal(image, brick()[:, 16:76, 16:80])
    assert report == {"texture": 0.0, "flow": 0.0, "renewed": 0.0}


def test_what_a_try_leaves_as_it_is_rests_until_it_is_worn_more(monkeypatch: pytest.MonkeyPatch) -> None:
    renewal = Renewal(Film.of(Exemplar.of(brick()), turn=False), SHAPE, replace(QUICK, blocks=99))
    source, left = copied(30), None
    for number in range(9):  # until no try helps any more
        before = source
        source, _, left, _ = renewal(source, WHOLE, torch.Generator().manual_seed(number), left=left)
    assert torch.equal(source, before)
    tried: list[int] = []
    find = renewal.blocks.nearest
    monkeypatch.setattr(renewal.blocks, "nearest", lambda *given: tried.append(len(given[0])) or find(*given))
    renewal(source, WHOLE, torch.Generator().manual_seed(0), left=left)
    assert not tried
    renewal(source, WHOLE, torch.Generator().manual_seed(0), left=left * 0.5)
    assert tried


def test_worn_texture_is_replaced_by_less_worn() -> None:
    renewal, source, image, report = renewed(copied(30))
    worn = renewal.read.picture(copied(30), WHOLE)
    changed = (source != copied(30)).any(0)
    assert report["texture"] == pytest.approx(
        float((renewal.wear(renewal.read(copied(30)), copied(30), WHOLE) - QUICK.tolerance).clamp(min=0).mean())
    )
    assert report["renewed"] == pytest.approx(float(changed.float().mean()), abs=1e-6)
    assert report["renewed"] > 0.1
    assert report["flow"] == pytest.approx(flow_energy(renewal, copied(30), source) / changed.numel(), rel=1e-3)
    before = float(renewal.wear(worn, copied(30), WHOLE).mean())
    for number in range(6):
        source, image, *_ = renewal(source, WHOLE, torch.Generator().manual_seed(number))
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


def flow_energy(renewal: Renewal, carried: Tensor, source: Tensor) -> float:
    """lambda sum K |x - x+|^2, in variances."""
    before, after = renewal.read(carried), renewal.read(source)
    weight = renewal.settings.flow_weight * gradient_weight(before, torch.ones(1, 1, 1))
    return float((weight * (after - before).square()[0]).sum() / brick().var(correction=0))


def seams_energy(renewal: Renewal, source: Tensor) -> float:
    """What the copies on both sides of each jump of the offset differ by there, in deviations."""
    cost = 0.0
    for axis in (1, 2):
        step = torch.tensor([float(axis == 2), float(axis == 1)]).view(2, 1, 1)
        s, t = source.narrow(axis, 0, source.shape[axis] - 1), source.narrow(axis, 1, source.shape[axis] - 1)
        jump = (t - s - step).square().sum(0) >= 1.5**2
        for one, other in ((s, t - step), (s + step, t)):
            colors = [flow.warp(brick(), place, "bilinear")[0] for place in (one, other)]
            cost += float(((colors[0] - colors[1]).abs() * jump).sum())
    return renewal.settings.seam * cost / float(brick().std(correction=0))


def energy(renewal: Renewal, carried: Tensor, source: Tensor) -> float:
    """U of the module's docstring, of a frame that shows `source` and was carried as `carried`."""
    wear = (renewal.wear(renewal.read(source), source, WHOLE) - renewal.settings.tolerance).clamp(min=0)
    return float(wear.sum()) + flow_energy(renewal, carried, source) + seams_energy(renewal, source)


@pytest.mark.parametrize("weights", [(0.025, 1.2), (0.05, 0.2), (0.0, 0.6)])
@pytest.mark.parametrize("degrees", [30.0, 40.0])
def test_a_renewal_never_raises_the_energy(weights: tuple[float, float], degrees: float) -> None:
    """All of U, measured anew over the whole frame before and after; and again from what the first one left."""
    settings = replace(QUICK, flow_weight=weights[0], seam=weights[1], tolerance=0.0)
    before = copied(degrees)
    for _ in range(3):
        renewal, after, _, _ = renewed(before, settings=settings)
        assert energy(renewal, before, after) <= energy(renewal, before, before) + 1e-3
        before = after
    assert bool((after != copied(degrees)).any())


def test_a_block_that_costs_more_than_the_cut_guessed_is_not_laid(monkeypatch: pytest.MonkeyPatch) -> None:
    measured = Wear.after

    def worse(self: Wear, worn: Worn, *changed: Any) -> Worn:
        after = measured(self, worn, *changed)
        return replace(after, wear=after.wear + 1.0)

    assert renewed(copied(30))[3]["renewed"] > 0
    monkeypatch.setattr(Wear, "after", worse)
    _, source, _, report = renewed(copied(30))
    assert torch.equal(source, copied(30))
    assert report["renewed"] == report["flow"] == 0


def test_a_renewal_mends_an_old_seam() -> None:
    """A piece from elsewhere within a copy: taking the copy again there costs nothing and ends its seams."""
    source = copied()
    source[1, 24:29, 26:32] += 9.0
    renewal = Renewal(Film.of(Exemplar.of(brick())), SHAPE, replace(QUICK, flow_weight=0.0, usage=0.0))
    frame = renewal.begin(source, WHOLE, ~WHOLE)
    assert frame.sheet.total == pytest.approx(seams_energy(renewal, source) * COUNTS, rel=1e-3)
    assert frame.sheet.total > 0
    renewal._renew(frame, [(18, 18)], torch.Generator().manual_seed(0))
    assert frame.sheet.total == 0
    assert torch.equal(frame.source, copied())


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
    image = Renewal(Film.of(exemplar, turn=False), SHAPE, QUICK).read(copied(3.0) + 0.4)
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
    for wrong in ({"flow_weight": -1.0}, {"seam": math.nan}, {"inertia": -1.0}, {"shades": math.nan}, {"blocks": -1}):
        with pytest.raises(InputError, match="has a weight or number of blocks that is not 0 or more"):
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


@pytest.mark.parametrize("side", [2, 3, 4, 5, 6, 7])
def test_every_pixel_lies_in_a_block_however_small_the_exemplar(side: int) -> None:
    """Blocks of 3 px that began every 4 px would leave gaps that no block ever fills."""
    renewal = Renewal(Film.of(Exemplar.of(brick()[:, :side, :side])), (13, 18), QUICK)
    covered = [torch.zeros(n, dtype=torch.bool) for n in (13, 18)]
    for line, n in zip(covered, (13, 18), strict=True):
        for start in starts(n, renewal.blocks.sides[0]).tolist():
            line[start : start + renewal.blocks.sides[0]] = True
        assert bool(line.all())


def test_a_frame_is_filled_from_a_tiny_exemplar() -> None:
    source = torch.full((2, 12, 14), -9.0)
    exemplar = Exemplar.of(brick()[:, :6, :6])
    inside = torch.ones(12, 14, dtype=torch.bool)
    renewal = Renewal(Film.of(exemplar, turn=False), (12, 14), replace(QUICK, block=3))
    filled, *_ = renewal(source, inside, torch.Generator().manual_seed(0))
    assert bool(owned(exemplar, filled).all())
