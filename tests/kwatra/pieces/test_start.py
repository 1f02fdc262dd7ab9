import math
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pytest
import torch
from skimage import data
from torch import Tensor

from kwatra import Exemplar, InputError, Settings, SoftPixels, Stay, optimize
from kwatra.base import generator_of
from kwatra.loop.laying import USAGE, USAGE_IN_TIME, block_size, block_start
from kwatra.loop.task import task_of
from kwatra.pieces import BlockStart, layer
from kwatra.pieces.choosing import candidates, charges
from kwatra.terms.controls import Wish


def stripes(height, width, period):
    return ((torch.arange(width) % period) < period // 2).float().expand(1, height, width).contiguous()


class Laid(NamedTuple):
    x: Tensor
    where: Tensor
    start: BlockStart


def run(exemplar, shape, block, grain=(1, 1), seed=0, **options):
    options = {"usage": 0.35, "seams": 1} | options
    start = BlockStart(exemplar, shape, block, grain, torch.Generator().manual_seed(seed), **options)
    where = start.run()
    return Laid(exemplar.canvas[(slice(None), *where)], where, start)


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_blocks_of_a_periodic_exemplar_continue_its_period(wrap, seed):
    twice = Exemplar.of([stripes(48, 48, 6)] * 2)  # of several images none hangs over: it then need not know the period
    x, _, _ = run(twice, (72, 96), (24, 24), seed=seed, wraps=(wrap, wrap))
    assert any(torch.equal(x, stripes(72, 96, 6).roll(phase, 2)) for phase in range(6))


def test_the_map_says_where_the_pixels_come_from_and_offsets_lie_on_the_grain():
    image = torch.rand(2, 64, 60, generator=torch.Generator().manual_seed(0))
    x, where, _ = run(Exemplar.of(image), (70, 90), (24, 20), (4, 4))
    assert torch.equal(x, image[(slice(None), *where)])
    place = torch.stack(torch.meshgrid(torch.arange(70), torch.arange(90), indexing="ij"))
    assert int(((where - place) % 4).abs().max()) == 0


def test_aligned_blocks_cost_less_seams_than_random_ones():
    cells = torch.rand(1, 16, 16, generator=torch.Generator().manual_seed(0))
    exemplar = Exemplar.of(cells.repeat_interleave(4, 1).repeat_interleave(4, 2))
    aligned, anyhow = (run(exemplar, (96, 96), (24, 24), aligned=how).start.sheet.total for how in (True, False))
    assert 2 * aligned < anyhow


def test_blocks_with_cheaper_seams_are_laid():
    image = torch.from_numpy(data.gravel()[:64, :64].astype("float32") / 255)[None]

    def read(place):
        y, x = place.clamp(0, 63)
        return image[0, y, x]

    def seams(count, seed):
        where = run(Exemplar.of(image), (128, 128), (24, 24), seed=seed, seams=count, usage=0.0).where
        place = torch.stack(torch.meshgrid(torch.arange(128), torch.arange(128), indexing="ij"))
        offset, cost = where - place, 0.0
        for axis in (1, 2):
            p, q = (place.narrow(axis, k, 127) for k in (0, 1))
            mine, theirs = (offset.narrow(axis, k, 127) for k in (0, 1))
            cost += sum(float((read(at + mine) - read(at + theirs)).abs().sum()) for at in (p, q))
        return cost

    assert sum(seams(8, seed) for seed in range(3)) < sum(seams(1, seed) for seed in range(3))


def test_usage_spreads_the_blocks_over_the_exemplar():
    image = torch.full((1, 64, 64), 0.5)  # every block fits: only usage decides

    def unevenness(usage):
        return float(run(Exemplar.of(image), (128, 128), (16, 16), usage=usage).start.layer.used.std())

    assert unevenness(1.0) < 0.9 * unevenness(0.0)


def test_what_is_shown_again_is_shown_far_away(monkeypatch):
    image = torch.rand(1, 96, 96, generator=torch.Generator().manual_seed(0)) / 100 + 0.5

    def share_beside():
        """Of the pixels, how many are shown again within 48 pixels by another copy."""
        _, row, column = np.indices((1, 192, 192))
        where = run(Exemplar.of(image), (192, 192), (32, 32), usage=0.0).where.numpy()
        source = where[0] * 96 + where[1]
        order = np.argsort(source.ravel(), kind="stable")
        source, row, column = source.ravel()[order], row.ravel()[order], column.ravel()[order]
        twice = [
            ((source[k:] == source[:-k]) & (np.hypot(row[k:] - row[:-k], column[k:] - column[:-k]) < 48)).sum()
            for k in range(1, 8)
        ]
        return sum(twice) / source.size

    heeded = share_beside()
    monkeypatch.setattr(candidates, "NEAR", 0.0)
    assert heeded < 0.8 * share_beside()


def test_blocks_avoid_holes():
    mask = torch.ones(40, 40, dtype=torch.bool)
    mask[18:22, 18:22] = False
    where = run(Exemplar.of([torch.rand(1, 40, 40)], masks=[mask]), (60, 60), (24, 24)).where
    assert bool(mask[tuple(where)].all())


def test_an_exemplar_of_single_pixels_is_refused():
    mask = torch.zeros(9, 9, dtype=torch.bool)
    mask[::2, ::2] = True
    with pytest.raises(InputError, match="leaves too little to copy from"):
        run(Exemplar.of([torch.rand(1, 9, 9)], masks=[mask]), (20, 20), (4, 4))


def test_block_size_is_a_share_of_the_exemplar_and_at_most_half_the_output():
    exemplar = Exemplar.of(torch.rand(1, 64, 100))
    assert block_size(exemplar, (300, 300), 0.5, (4, 4)) == (32, 48)
    assert block_size(exemplar, (40, 300), 0.5, (4, 4)) == (20, 48)
    assert block_size(Exemplar.of(torch.rand(1, 3, 3)), (9, 9), 0.5, (4, 4)) == (3, 3)


def test_videos_start_from_blocks_too():
    video = torch.rand(1, 8, 24, 24, generator=torch.Generator().manual_seed(0))
    x, where, _ = run(Exemplar.of(video), (10, 40, 40), (4, 12, 12), (1, 2, 2))
    assert torch.equal(x, video[(slice(None), *where)])


def test_blocks_go_where_they_agree_with_a_wish():
    # dark left half, light right half; the wish asks for light above dark
    image = torch.rand(1, 48, 96, generator=torch.Generator().manual_seed(0)) * 0.2
    image[..., 48:] += 0.7
    value = torch.full((1, 96, 60), 0.1)
    value[:, :48] = 0.8
    x = run(Exemplar.of(image), (96, 60), (12, 12), wish=Wish(torch.ones(1, 1, 1).expand_as(value), value)).x
    assert float(x[:, :44].mean()) > 0.75
    assert float(x[:, 52:].mean()) < 0.15
    blind = run(Exemplar.of(image), (96, 60), (12, 12)).x
    assert abs(float(blind[:, :44].mean() - blind[:, 52:].mean())) < 0.5


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("price", ["EVEN", "LIKE"])
def test_cuts_show_the_places_of_a_scene_and_their_kinds_more_evenly(price, seed, monkeypatch):
    clip = torch.rand(1, 6, 40, 40, generator=torch.Generator().manual_seed(seed)) * torch.linspace(1, 0.05, 40)
    exemplar, shape, block = Exemplar.of(clip), (6, 60, 60), (6, 18, 18)
    places = [Stay(3.0).place_charge(exemplar, shape, block)]
    other = {"EVEN": "LIKE", "LIKE": "EVEN"}[price]
    monkeypatch.setattr(charges, other, 0.0)

    def unevenness():
        start = run(exemplar, shape, block, (1, 1, 1), seed=seed, seams=3, usage=1.0, places=places).start
        shown = start.layer.used.sum(0)
        if price == "LIKE":
            shown = np.bincount(start.layer.scene.kind, shown.ravel())
        return float(shown.std() / shown.mean())

    heeded = unevenness()
    monkeypatch.setattr(charges, price, 0.0)
    assert heeded < 0.97 * unevenness()


def test_each_seed_lays_other_blocks_of_a_scene_though_few_may_come_first():
    noise = torch.rand(1, 8, 24, 24, generator=torch.Generator().manual_seed(2))
    exemplar = Exemplar.of(0.5 * noise + torch.linspace(0, 1, 24)[:, None])
    shape, block = (12, 36, 36), (4, 12, 12)
    options = {"seams": 6, "usage": 1.0, "places": [Stay(1.0).place_charge(exemplar, shape, block)]}
    laid = [run(exemplar, shape, block, (1, 1, 1), seed=seed, **options).where for seed in range(5)]
    assert max(float((a == b).all(0).float().mean()) for a, b in combinations(laid, 2)) < 0.5


def checkers(height, width, cell):
    y, x = torch.meshgrid(torch.arange(height) // cell, torch.arange(width) // cell, indexing="ij")
    return ((x + y) % 2).float()[None]


@pytest.mark.parametrize("wrap", [False, True])
def test_a_periodic_checkerboard_is_continued_exactly(wrap):
    x = run(Exemplar.of(checkers(64, 64, 4)), (64, 96), (20, 24), (2, 2), wraps=(wrap, wrap), seams=3).x
    assert any(torch.equal(x, checkers(72, 104, 4)[:, a : a + 64, b : b + 96]) for a in range(8) for b in range(8))


def test_seams_remembered_are_those_that_are_there(recomputed_seams):
    image = torch.from_numpy(data.gravel()[:64, :64].astype("float32") / 255)[None]
    for shape, block, wrap in (((96, 80), (24, 24), False), ((96, 80), (24, 24), True)):
        sheet = run(Exemplar.of(image), shape, block, (2, 2), wraps=(wrap, wrap), seams=3).start.sheet
        np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)
        assert sheet.total == int(sheet.seams.sum())
    video = torch.rand(1, 8, 24, 24, generator=torch.Generator().manual_seed(0))
    sheet = run(Exemplar.of(video), (10, 30, 30), (4, 12, 12), (1, 1, 1), seams=2).start.sheet
    np.testing.assert_array_equal(recomputed_seams(sheet), sheet.seams)


def test_blocks_laid_again_lower_the_seams(monkeypatch):
    image = torch.from_numpy(data.brick()[:64, :64].astype("float32") / 255)[None]
    again = run(Exemplar.of(image), (128, 128), (24, 24), seams=3).start.sheet.total
    monkeypatch.setattr(layer, "AGAIN", 0)
    assert again < 0.97 * run(Exemplar.of(image), (128, 128), (24, 24), seams=3).start.sheet.total


def test_use_is_counted_as_pixels_are_shown():
    image = torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0))
    _, where, start = run(Exemplar.of(image), (50, 60), (12, 12), seams=2)
    count = torch.zeros(32, 32).index_put(tuple(where), torch.ones(()), accumulate=True)
    np.testing.assert_array_equal(start.layer.used, count.numpy())


def laid(monkeypatch, exemplar, shape, terms=(), settings=None):
    """The start that an optimization begins with."""
    starts, run = [], BlockStart.run
    with monkeypatch.context() as patched:
        patched.setattr(BlockStart, "run", lambda self, draft: starts.append(self) or run(self, draft))
        block_start(task_of(exemplar, shape, settings or Settings(), terms, None, "aligned", 0), exemplar)
    return starts[0]


def test_use_costs_more_in_videos_and_nothing_where_all_only_translates(monkeypatch):
    sheet = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    panned = torch.stack([sheet[:, t : t + 24, 5:29] for t in range(4)], 1)
    boiling = torch.rand(1, 4, 24, 24, generator=torch.Generator().manual_seed(0))
    given = (sheet, (20, 20)), (boiling, (4, 20, 20)), (panned, (4, 20, 20))
    assert [laid(monkeypatch, Exemplar.of(x), shape).layer.candidates.asked.usage for x, shape in given] == [
        USAGE,
        USAGE_IN_TIME,
        0.0,
    ]
    wish = SoftPixels(torch.ones(1, 4, 20, 20), torch.ones(1, 4, 20, 20))
    assert laid(monkeypatch, Exemplar.of(boiling), (4, 20, 20), (wish,)).layer.candidates.asked.usage == USAGE


def test_use_counts_less_the_more_often_a_still_shows_its_exemplar(monkeypatch):
    sheet = Exemplar.of(torch.rand(1, 16, 16, generator=torch.Generator().manual_seed(0)))
    usage = [
        laid(monkeypatch, sheet, shape).layer.candidates.asked.usage
        for shape in ((24, 24), (32, 32), (32, 64), (64, 64))
    ]
    assert usage == [USAGE, USAGE, USAGE / 2, USAGE / 4]
    assert laid(monkeypatch, sheet, (32, 64), settings=Settings(even=0.5)).layer.candidates.asked.usage == USAGE / 4


@pytest.mark.parametrize("rotate", [(), (30.0, 60.0)])
@pytest.mark.parametrize("side", [4, 6, 8, 10])
def test_a_tiny_exemplar_takes_few_blocks(side, rotate, monkeypatch):
    """A block is as wide as the exemplar or 8 px: pieces of 2 px would be thousands."""
    image = torch.rand(1, side, side, generator=torch.Generator().manual_seed(0))
    for colors in (image, torch.full_like(image, 0.5)):
        exemplar = Exemplar.of(colors, rotate=rotate)
        blocks = laid(monkeypatch, exemplar, (50, 40)).sheet.patches
        assert len(blocks) <= 2.2 * math.ceil(50 / (0.75 * min(side, 8))) * math.ceil(40 / (0.75 * min(side, 8)))


@pytest.mark.parametrize("shape", [(150, 170), (40, 61)])
def test_an_exactly_periodic_picture_is_continued_exactly(shape):
    """Cells of 32 px in a picture of 85: hardly more than one period."""
    cells = checkers(85, 85, 32)
    made = optimize(Exemplar.of(cells), shape, seed=3)
    assert torch.allclose(made.image, checkers(*shape, 32), atol=1e-6)
    nearly = cells + 0.1 * torch.rand(1, 85, 85, generator=torch.Generator().manual_seed(0))
    assert not torch.equal(
        optimize(Exemplar.of(nearly), shape, seed=3).image, optimize(Exemplar.of(nearly), shape).image
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_two_periods_of_an_ornament_are_continued_by_whole_periods(seed):
    generator = torch.Generator().manual_seed(seed)
    cell = torch.rand(3, 32, 30, generator=generator)
    cell[:, 16:26] = cell[:, :10]  # courses that are alike half a period on
    cell[:, :, 15:25] = cell[:, :, :10]
    picture = cell.repeat(1, 3, 3)[:, :60, :57]
    result = optimize(
        Exemplar.of(picture + 0.1 * torch.randn(picture.shape, generator=generator)), (90, 100), seed=seed
    )
    y, x = (result.source[1 + axis] - torch.arange(n).unsqueeze(1 - axis) for axis, n in enumerate((90, 100)))
    assert bool(((y - y[0, 0]) % 32 == 0).all() & ((x - x[0, 0]) % 30 == 0).all())


@pytest.mark.parametrize("striped", [False, True])
def test_any_number_of_threads_lays_the_same_blocks(striped):
    image = stripes(48, 48, 12).expand(3, -1, -1) if striped else torch.rand(3, 40, 44, generator=generator_of(1))
    laid = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        laid.append(run(Exemplar.of(image.contiguous()), (80, 90), (20, 20), seams=6).where)
    assert torch.equal(laid[0], laid[1])
    assert torch.equal(laid[0], laid[2])
