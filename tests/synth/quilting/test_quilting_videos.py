"""Quilted videos: seams in time, starts, loops."""

import dataclasses
from unittest.mock import Mock

import numpy as np
import pytest
import torch
from dots import copied, texture

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams.cost import ACROSS_TIME, normalized
from kwatra.pieces.seams.mosaic import Mosaic
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting import QuiltSettings, quilt_video
from synth.quilting import displaced as displacing
from synth.quilting.displaced import flash, lasting_region
from synth.quilting.starts import STARTS, cheapest_start, lay_all
from synth.quilting.synthesis import new_placer, new_sheet, run, sources_of


def test_a_seam_in_time_is_spread_over_frames() -> None:
    # Two clips that differ by as much everywhere but for noise: the smallest surface between them is one frame.
    generator = np.random.default_rng(0)
    noise = generator.random((2, 1, 16, 24, 24), np.float32)
    share = []
    for divided in (False, True):
        sources = Mosaic([*noise])
        sheet = Sheet(sources, (16, 24, 24), (False,) * 3, QuiltSettings(normalized=divided).cost_of(sources))
        sheet.lay(Patch(0, (0, 0, 0), Box((0, 0, 0), (16, 24, 24))))
        ends = np.zeros((16, 24, 24), bool)
        ends[-1] = True
        sheet.lay(Patch(1, (0, 0, 0), Box((1, 0, 0), (15, 24, 24))), must=ends[1:])
        share.append(flash(sheet) / int(sheet.seams[0].sum()))
    assert share[1] < share[0]


def test_a_seam_between_frames_costs_more_than_one_within() -> None:
    flat = Mosaic([np.zeros((1, 4, 4, 4), np.float32), np.ones((1, 4, 4, 4), np.float32)])
    cost = normalized(flat)
    s, t = flat.places(0, [np.array([1])] * 3), flat.places(1, [np.array([1])] * 3)
    prices = [int(cost.seam(s, t, axis, 3).item()) for axis in range(3)]
    assert prices == pytest.approx([ACROSS_TIME * prices[2], prices[2], prices[2]], abs=ACROSS_TIME)


def test_what_is_seen_of_the_start_of_the_least_flash_is_taken() -> None:
    clip = texture(1, 10, 12, 12)
    settings = dataclasses.replace(QuiltSettings(placement="random", normalized=True), refine=3)
    priced = []

    def begun() -> Sheet[Mosaic]:
        return new_sheet(sources_of(clip, settings), (20, 12, 12), settings)

    def sew(sheet: Sheet[Mosaic], own: QuiltSettings) -> str:
        run(sheet, new_placer(sheet, own, (4, 12, 12)), own, lambda what, part: None)
        priced.append((flash(sheet), [sheet.patches[k] for k in np.unique(sheet.label)], len(sheet.patches)))
        return ""

    patches, _ = cheapest_start(begun, sew, settings, flash)
    # Patches that others cover altogether are not laid again.
    assert patches == min(priced, key=lambda trial: trial[0])[1]
    assert any(len(seen) < laid for _, seen, laid in priced)


def test_patches_of_short_clips_overlap_for_some_frames() -> None:
    assert lasting_region((72, 40, 80), 0.25) == (18, 10, 20)
    assert lasting_region((12, 40, 80), 0.25) == (8, 10, 20)
    assert lasting_region((5, 40, 80), 0.25) == (5, 10, 20)


def test_the_cheapest_start_is_taken_and_laid_again_the_same() -> None:
    settings = QuiltSettings(refine=4, seed=3)
    sources = sources_of(texture(1, 20, 20), settings)
    seeds = []

    def begun() -> Sheet[Mosaic]:
        return new_sheet(sources, (36, 36), settings)

    def sew(sheet: Sheet[Mosaic], own: QuiltSettings) -> str:
        seeds.append(own.seed)
        return run(sheet, new_placer(sheet, own, (6, 6)), own, lambda what, part: None)[1]

    patches, _ = cheapest_start(begun, sew, settings)
    again = begun()
    history = lay_all(again, patches, lambda what, part: None)
    assert len(set(seeds)) == len(seeds) == STARTS
    assert history[-1] == again.total
    assert history == sorted(history, reverse=True)
    totals = []
    for seed in seeds:
        own = dataclasses.replace(settings, seed=seed)
        sheet = begun()
        run(sheet, new_placer(sheet, own, (6, 6)), own, lambda what, part: None)
        totals.append(sheet.total)
    assert again.total == min(totals) < max(totals)


def test_a_loop_ends_where_it_begins() -> None:
    clip = texture(1, 14, 12, 12)
    for mode, size in (("time", (12, 12)), ("spacetime", (15, 15))):
        result = quilt_video(clip, 20.0, size, mode=mode, loop=True, hold=4)
        assert result.image.shape == (1, 20, *size)
        # The frames before the first are the last held ones, so their offsets run on from the end to the start.
        gap = (result.image[:, 0] - result.image[:, -1]).abs().mean()
        steps = (clip[:, 1:] - clip[:, :-1]).abs().mean((0, 2, 3))
        assert gap <= 1.5 * steps.max()


def test_a_larger_looping_video_says_where_each_pixel_is_from() -> None:
    clip = texture(2, 12, 16, 16)
    result = quilt_video(clip, size=(20, 20), mode="spacetime", loop=True, settings=QuiltSettings(refine=5))
    torch.testing.assert_close(result.image, copied(result, clip), rtol=0, atol=0)
    for axis in range(3):
        borders = result.patch.narrow(axis, 1, result.patch.shape[axis] - 1) == result.patch.narrow(
            axis, 0, result.patch.shape[axis] - 1
        )
        assert bool((result.seams[axis].narrow(axis, 0, borders.shape[axis])[borders] == 0).all())
    assert result.cost == pytest.approx(float(result.seams.sum()))
    assert result.history[-1] == pytest.approx(result.cost)
    assert list(result.history) == sorted(result.history, reverse=True)


def test_a_periodic_clip_loops_without_any_cost() -> None:
    base = texture(2, 8, 10, 10)
    clip = base.repeat(1, 3, 1, 1)
    result = quilt_video(clip, mode="transition", loop=True)
    assert result.cost == 0
    assert result.image.shape[1] % 8 == 0
    twice = quilt_video(clip, 2 * result.image.shape[1], mode="transition", loop=True)
    torch.testing.assert_close(twice.image, result.image.repeat(1, 2, 1, 1), rtol=0, atol=0)
    torch.testing.assert_close(twice.image, copied(twice, clip), rtol=0, atol=0)


@pytest.mark.parametrize("mode", ["transition", "time"])
def test_a_video_remembers_the_seam_across_its_join(mode: str) -> None:
    clip = texture(2, 12, 9, 9)
    settings = QuiltSettings(placement="random", refine=3)
    result = quilt_video(clip, None if mode == "transition" else 18, mode=mode, loop=True, hold=3, settings=settings)
    seam = result.seams[0, -1]
    place = result.offset.numpy() + np.indices(result.patch.shape)
    ahead = np.clip(place[0, -1] + 1, 0, 11)
    continues = torch.from_numpy(ahead == place[0, 0])
    assert bool((seam[continues] == 0).all())
    if mode == "transition":
        assert bool(continues.all())


def test_mode_time_moves_nothing_in_space() -> None:
    result = quilt_video(texture(1, 10, 12, 12), 20, mode="time")
    assert bool((result.offset[1:] == 0).all())


@pytest.mark.parametrize(("side", "allowed"), [(100, 10**6), (100, 50_000), (400, 50_000)])
def test_patches_tried_on_small_frames_are_no_larger_than_may_be_cut(
    monkeypatch: pytest.MonkeyPatch, side: int, allowed: int
) -> None:
    asked: list[int] = []

    def placed(*_: object, most: int, **__: object) -> None:
        asked.append(most)
        raise KeyboardInterrupt

    monkeypatch.setattr(displacing, "new_placer", placed)
    monkeypatch.setattr(displacing, "cheapest_start", lambda make, sew, settings, cost: sew(make(), settings))
    monkeypatch.setattr(displacing, "MOST_PIXELS", allowed)
    with pytest.raises(KeyboardInterrupt):
        displacing.displaced(torch.zeros(1, 12, side, 80), lambda clip: Mock(), QuiltSettings(), lambda *_: None)
    small = displacing.shrunk(torch.zeros(1, 12, side, 80), displacing.SMALL)[0, 0].numel()
    wanted = max(allowed / (side * 80), 4)  # frames of the clip, of which a few are cut whatever their size
    assert wanted - 1 < asked[0] / small <= wanted
