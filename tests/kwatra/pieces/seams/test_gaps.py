import numpy as np
import pytest
import torch
from bench_elements import cut_elements
from made import MADE

from kwatra import Exemplar, Settings, begin, improve, optimize
from kwatra.elements import Ground, Lattice, find_ground, find_outlines
from kwatra.pieces import BlockStart, Fitted, Gaps, Hidden, Mosaic, blocks, find_gaps, hidden_along, hidden_seams
from kwatra.pieces.seams.gaps import ALIGNED, CUTTING, SURE
from kwatra.terms import Wish


def cut(made, monkeypatch=None):
    """The share of elements that blocks of a texture cut; with the patch, where gaps are not heeded."""
    if monkeypatch is not None:
        monkeypatch.setattr("kwatra.pieces.blocks.find_gaps", lambda *_: None)
    generator = torch.Generator().manual_seed(0)
    start = BlockStart(Exemplar.of(made.image), (192, 192), (80, 80), (1, 1), generator, usage=0.5, seams=6)
    where = start.run()
    return cut_elements(made.numbers.numpy(), (where[0] * 128 + where[1]).numpy(), made.touching)


@pytest.mark.parametrize(("name", "most"), [("coins", 0.1), ("stones", 0.25)])
def test_elements_stay_whole_where_there_are_gaps(name, most, monkeypatch):
    made = MADE[name](128, 24, 0)
    whole, torn = cut(made), cut(made, monkeypatch)
    assert whole["cut"] <= most
    assert whole["cut"] < torn["cut"]


@pytest.mark.parametrize(("name", "most"), [("patches", 0.25), ("confetti", 0.8)])
def test_seams_between_elements_that_touch_run_along_their_outlines(name, most, monkeypatch):
    made = [MADE[name](128, 24, seed) for seed in range(3)]
    whole, torn = ([cut(each, patch)["mixed"] for each in made] for patch in (None, monkeypatch))
    assert sum(whole) < most * sum(torn)


def around(made, weight, **other):
    """A start of a texture around what is wished for in its middle."""
    value = torch.zeros(3, 192, 192)
    value[:, 48:144, 48:144] = made.image[:, 16:112, 16:112]
    wish, generator = Wish(weight, value), torch.Generator().manual_seed(1)
    exemplar = Exemplar.of(made.image)
    return BlockStart(exemplar, (192, 192), (40, 40), (1, 1), generator, usage=0.5, seams=6, wish=wish, **other)


@pytest.mark.parametrize("name", ["coins", "stones"])
def test_elements_stay_whole_around_pixels_that_are_given(name, monkeypatch):
    made, weight = MADE[name](128, 24, 0), torch.zeros(3, 192, 192)
    weight[:, 48:144, 48:144] = 1000
    shares = []
    for heeded in (True, False):
        if not heeded:
            monkeypatch.setattr("kwatra.pieces.blocks.find_gaps", lambda *_: None)
        where = around(made, weight).run()
        shares.append(cut_elements(made.numbers.numpy(), (where[0] * 128 + where[1]).numpy())["cut"])
    assert shares[0] < 0.8 * shares[1]


def test_blocks_grow_around_given_pixels_and_not_where_all_are_wished_for():
    made, some, every = MADE["coins"](128, 24, 0), torch.zeros(3, 192, 192), torch.full((3, 192, 192), 0.02)
    some[:, 48:144, 48:144] = 1
    grown, kept = around(made, some), around(made, every)
    assert grown.layer.corners.block > (40, 40) == kept.layer.corners.block
    assert grown.layer.overlap == kept.layer.overlap


def test_a_guide_is_no_ground():
    """A map of cells that goes with the colors, and what lies between them: no seam is hidden there."""
    noise = torch.rand(3, 128, 128, generator=torch.Generator().manual_seed(0))
    bars = (torch.arange(128) % 16 < 12).float()
    guide = 100 * (bars[:, None] * bars)[None]
    weight = torch.zeros(4, 192, 192)
    weight[3] = 1
    wish, generator = Wish(weight, torch.zeros(4, 192, 192)), torch.Generator().manual_seed(0)
    guided = Exemplar.of(torch.cat([noise, guide]))
    assert find_gaps(guided, Mosaic([guided.canvas.numpy()]), 1.0) is not None
    start = BlockStart(guided, (192, 192), (40, 40), (1, 1), generator, usage=0.5, seams=6, wish=wish)
    assert start.gaps is None


def test_depths_are_told_apart_in_their_deviations_and_not_at_all_where_they_are_one():
    depth = np.array([[0.0, 0.2], [0.2, 1.0]], np.float32)
    unlike = Hidden(depth, 1.0, 24.0, ALIGNED, 1.0).unlike
    assert np.allclose([unlike.mean(), unlike.std()], [0, 1], atol=1e-6)
    assert np.allclose(np.diff(unlike), np.diff(depth) / depth.std())
    assert (Hidden(np.ones((2, 2), np.float32), 1.0, 24.0, ALIGNED, 1.0).unlike == 0).all()


def test_each_source_of_a_mosaic_is_as_deep_as_it_is_said_to_be():
    rng = np.random.default_rng(0)
    mosaic = Mosaic([rng.random((3, 6, 8), np.float32) for _ in range(2)])
    depth, parts = rng.random((6, 8), np.float32), rng.integers(0, 3, (6, 8))
    shown = tuple(rng.integers(0, side, (6, 8)) for side in (6, 8))
    cost = Hidden(depth, 0.5, 8.0, ALIGNED, 1.0, parts).cost(mosaic, [..., shown], 20.0)
    assert cost.depth.least == pytest.approx(CUTTING * 0.5 * 20.0)
    for number, there in enumerate((np.indices((6, 8)), shown)):
        places = mosaic.places(number, [np.arange(6), np.arange(8)])
        np.testing.assert_array_equal(cost.depth.at(places), depth[tuple(there)])
        np.testing.assert_array_equal(cost.depth.part(places), parts[tuple(there)])
    assert Hidden(depth, 0.5, 8.0, ALIGNED, 1.0).cost(mosaic, [..., ...], 20.0).depth.part is None


def test_outlines_hide_seams_where_no_ground_does():
    for name in ("stones", "patches"):
        exemplar = Exemplar.of(MADE[name](128, 24, 0).image)
        ground, outlines, hidden = find_ground(exemplar), find_outlines(exemplar), hidden_seams(exemplar)
        if name == "stones":
            assert hidden.parts is None
            assert hidden.hides == ground.sure * ground.plain > 0.9
        else:
            assert np.array_equal(hidden.parts, outlines.parts)
            assert ground.sure * ground.plain < SURE < 0.5 < hidden.hides == outlines.hides
            assert np.allclose(hidden.depth, 1 - hidden.hides * (1 - outlines.depth))


@pytest.mark.parametrize("name", ["stones", "patches"])
def test_seams_of_a_large_image_are_hidden_where_they_are_at_half_the_resolution(name, monkeypatch):
    image = MADE[name](201, 32, 0).image
    monkeypatch.setattr("kwatra.pieces.seams.gaps.LOOKED_AT", 201**2 - 1)
    exemplar = Exemplar.of(image)
    hidden, seen = hidden_seams(exemplar), hidden_seams(exemplar.coarser((2, 2)))
    assert hidden[1:5] == (seen.hides, 2 * seen.size, seen.aligned, seen.dearer)
    assert hidden.depth.shape == (201, 201)
    assert np.abs(hidden.depth[:200, :200].reshape(100, 2, 100, 2).mean((1, 3)) - seen.depth).mean() < 0.02
    assert np.array_equal(hidden.depth[200], hidden.depth[199])
    assert (hidden.parts is None) == (seen.parts is None) == (name == "stones")
    if seen.parts is not None:
        assert np.array_equal(hidden.parts[:200:2, 1:201:2], seen.parts)
        assert np.array_equal(hidden.parts[:, 200], hidden.parts[:, 199])


def test_noise_has_no_gaps():
    noise = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    start = BlockStart(
        Exemplar.of(noise), (64, 64), (16, 16), (1, 1), torch.Generator().manual_seed(0), usage=0.5, seams=6
    )
    assert find_gaps(start.exemplar, start.sheet.sources, 1.0) is None


def test_blocks_grow_with_their_overlaps_where_the_exemplar_is_large_enough():
    made = MADE["coins"](128, 24, 0)
    start = BlockStart(Exemplar.of(made.image), (96, 96), (32, 32), (4, 4), torch.Generator(), usage=0.5, seams=6)
    found = start.gaps._replace(overlap=20)
    assert found.widened((32, 64), (8, 16), (96, 60), (4, 4)) == ((40, 64), (16, 20))
    assert found._replace(overlap=5).widened((32, 32), (8, 8), (96, 96), (4, 4)) == ((32, 32), (8, 8))
    assert start.layer.overlap == (16, 16)
    assert start.layer.corners.block == (40, 40)


def test_blocks_that_fit_between_holes_are_kept_where_larger_ones_do_not():
    made = MADE["coins"](128, 24, 0)
    mask = torch.ones(128, 128, dtype=torch.bool)
    mask[:, ::34] = False
    start = BlockStart(
        Exemplar.of([made.image], masks=[mask]), (96, 96), (32, 32), (1, 1), torch.Generator(), usage=0.5, seams=6
    )
    assert start.layer.corners.block == (32, 32)
    assert max(start.layer.overlap) <= 16


@pytest.mark.parametrize("wrap", [False, True])
def test_em_undoes_no_seam_that_goes_around_elements(wrap, monkeypatch):
    monkeypatch.setattr(blocks, "find_cells", lambda _: None)  # beside elements that were made whole none is EM's
    made = MADE["stones"](128, 20, 0)

    def mixed():
        where = optimize(Exemplar.of(made.image), (160, 160), settings=Settings(wrap=wrap)).where
        return cut_elements(made.numbers.numpy(), (where[0] * 128 + where[1]).numpy())["mixed"]

    kept = mixed()
    monkeypatch.setattr(Gaps, "cheaper", lambda self, before, *_: torch.ones_like(before[0], dtype=torch.bool))
    assert kept < mixed()


def test_the_map_tells_what_is_shown_beside_elements_that_were_made_whole(monkeypatch):
    monkeypatch.setattr(Gaps, "cheaper", lambda self, before, *_: torch.ones_like(before[0], dtype=torch.bool))
    exemplar = Exemplar.of(MADE["stones"](128, 20, 0).image)
    beginning = begin(exemplar, (96, 96))
    result = improve(beginning)
    changed = beginning.fitted.changed
    assert 0.02 < float(changed.float().mean()) < 0.9
    image, where = beginning.copied()
    assert torch.equal(result.where[:, changed], where[:, changed])
    assert torch.equal(result.image[:, changed], image[:, changed])
    assert not torch.equal(result.where, where)


def test_where_em_is_not_taken_pixels_are_the_exemplars_own(monkeypatch):
    def as_laid(where, *_):
        return Fitted(where.double(), where[0] < 0, where, torch.zeros(where.shape[1:]))

    monkeypatch.setattr(blocks, "fitted", as_laid)
    made = MADE["stones"](128, 20, 0)
    result = optimize(Exemplar.of(made.image), (96, 96))
    copied = made.image[(slice(None), *result.where)]
    assert float((result.image == copied).all(0).float().mean()) > 0.9
    assert torch.equal(result.stages[-1].image, result.image)


def test_what_is_seen_of_warped_elements_is_about_what_is_copied():
    made = MADE["stones"](128, 20, 0)
    result = optimize(Exemplar.of(made.image), (96, 96))
    copied = made.image[(slice(None), *result.where)]
    assert float((result.image == copied).all(0).float().mean()) > 0.65
    assert float((result.image - copied).abs().amax(0).quantile(0.9)) < 0.15
    assert torch.equal(result.stages[-1].image, result.image)


def test_blocks_grow_to_at_most_half_of_an_axis_that_wraps():
    made = MADE["coins"](128, 24, 0)
    wraps, generator = (True, False), torch.Generator()
    start = BlockStart(Exemplar.of(made.image), (64, 64), (30, 30), (1, 1), generator, wraps=wraps, usage=0.5, seams=6)
    assert start.layer.corners.block == (32, 37)
    start = BlockStart(Exemplar.of(made.image), (60, 64), (24, 24), (4, 4), generator, wraps=wraps, usage=0.5, seams=6)
    assert start.layer.corners.block == (28, 32)  # on the grain


def test_blocks_do_not_grow_where_elements_stand_on_a_lattice():
    made = MADE["coins"](128, 24, 0)
    lattice, generator = Lattice(24 * torch.eye(2), 1.0), torch.Generator()
    start = BlockStart(
        Exemplar.of(made.image), (96, 96), (32, 32), (4, 4), generator, usage=0.5, seams=6, repeats=lattice
    )
    assert start.layer.corners.block == (32, 32)
    assert start.layer.overlap == (16, 16)


def test_seams_are_hidden_on_the_ground_as_well_as_it_hides_them():
    ground = Ground(np.array([[0.0, 0.25, 1.0]]), 1.0, 1.0, 20.0)
    for hides, depth in ((1.0, [0.0, 0.25, 1.0]), (0.5, [0.5, 0.625, 1.0]), (0.0, [1.0, 1.0, 1.0])):
        assert hidden_along(ground, hides).depth.tolist() == [depth]
