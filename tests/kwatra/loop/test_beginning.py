from importlib import import_module
from weakref import ref

import pytest
import torch
from bench_elements import cut_elements
from made import MADE

from kwatra import Exemplar, HardPixels, InputError, Level, Settings, SoftPixels, begin, improve, optimize
from kwatra.base import generator_of
from kwatra.elements import find_rows, find_weave
from kwatra.loop import laying, looks
from kwatra.pieces import BlockStart, Box, find_cells

SMALL = Settings(levels=(Level(2, 8, 2), Level(1, 8, 2)))


def texture(size=48, channels=1):
    return torch.rand(channels, size, size, generator=generator_of(0))


@pytest.mark.parametrize("start", ["aligned", "blocks", "windows"])
def test_to_begin_and_to_improve_is_to_optimize_and_leaves_the_beginning_as_it_is(start):
    exemplar = Exemplar.of(texture())
    whole = optimize(exemplar, (40, 44), settings=SMALL, start=start, seed=3)
    beginning = begin(exemplar, (40, 44), SMALL, start=start, seed=3)
    for _ in range(2):
        made = improve(beginning)
        assert torch.equal(made.image, whole.image)
        assert torch.equal(made.where, whole.where)


@pytest.mark.parametrize(("size", "factor"), [(48, 1), (200, 2)])
def test_what_is_copied_is_seen_at_full_resolution(size, factor):
    exemplar = Exemplar.of(texture(size, 2))
    beginning = begin(exemplar, (50, 61), SMALL if factor > 1 else None)
    image, where = beginning.copied()
    assert beginning.factors == (factor, factor)
    assert where.shape == (2, 50, 61)
    assert torch.equal(image, exemplar.canvas[(slice(None), *where)])
    down, right = where[0, : 50 // factor * factor], where[1, :, : 61 // factor * factor]
    assert bool((down.view(-1, factor, 61).diff(dim=1) == 1).all())
    assert bool((right.view(50, -1, factor).diff(dim=2) == 1).all())


@pytest.mark.parametrize(("size", "settings"), [(48, None), (200, SMALL)])
def test_a_part_that_is_laid_anew_differs_and_the_rest_mostly_does_not(size, settings):
    first = begin(Exemplar.of(texture(size)), (3 * size, 3 * size), settings, seed=1)
    before = first.copied()[1].clone()
    part = Box((size // 2, size), (size, size + 7))
    other = first.anew(part, seed=5)
    assert torch.equal(first.copied()[1], before)
    assert torch.equal(other.copied()[1], first.anew(part, seed=5).copied()[1])
    differs = (other.copied()[1] != before).any(0).float()
    inside = torch.zeros_like(differs, dtype=torch.bool)
    inside[size // 2 : size // 2 + size, size : 2 * size + 7] = True
    assert float(differs[inside].mean()) > 0.5
    assert float(differs[~inside].mean()) < 0.35
    assert torch.equal(improve(other).image, improve(other).image)


def steered(kind, exemplar):
    """What a beginning of 60 x 70 pixels is told beside its texture and shape."""
    if kind == "kept":  # a part of the exemplar itself, which blocks go on from
        mask, image = torch.zeros(1, 60, 70, dtype=torch.bool), torch.zeros(1, 60, 70)
        mask[:, 20:40, 25:50], image[:, 20:40, 25:50] = True, exemplar.canvas[:, 5:25, 8:33]
        return {"terms": HardPixels(image, mask)}
    if kind == "wished":
        target = torch.rand(1, 60, 70, generator=generator_of(2))
        return {"terms": SoftPixels(target, torch.full((1, 60, 70), 0.3))}
    settings = {"coarse": SMALL, "wrapping": Settings(wrap=True), "random": None}
    return {"settings": settings[kind], "start": "blocks" if kind == "random" else "aligned"}


@pytest.mark.parametrize("kind", ["coarse", "kept", "wished", "random", "wrapping"])
def test_a_beginning_made_afresh_is_that_of_another_seed_bit_for_bit(kind):
    exemplar = Exemplar.of(texture(64))
    first, wanted = (begin(exemplar, (60, 70), seed=seed, **steered(kind, exemplar)) for seed in (1, 2))
    before, made = first.where.clone(), first.afresh(2)
    assert torch.equal(made.where, wanted.where)
    assert not torch.equal(made.where, before)
    assert torch.equal(first.where, before)
    assert torch.equal(made.afresh(1).where, before)
    assert torch.equal(improve(made).image, improve(wanted).image)


@pytest.mark.parametrize("kind", ["coarse", "kept", "wished", "random", "wrapping"])
def test_a_refined_draft_is_what_is_begun_at_once_bit_for_bit_and_the_draft_stays(kind):
    exemplar = Exemplar.of(texture(64))
    how = steered(kind, exemplar)
    wanted, draft = (begin(exemplar, (60, 70), seed=1, draft=draft, **how) for draft in (False, True))
    before = draft.where.clone()
    for _ in range(2):
        refined = draft.refined()
        assert torch.equal(refined.where, wanted.where)
        assert torch.equal(improve(refined).image, improve(wanted).image)
    assert torch.equal(draft.where, before)
    assert torch.equal(before, wanted.where) == (kind == "random")  # which lays nothing again
    assert refined.refined() is refined
    assert torch.equal(draft.afresh(2).where, begin(exemplar, (60, 70), seed=2, draft=True, **how).where)


def test_elements_are_made_whole_once_a_draft_is_refined():
    image = MADE["stones"](96, 20, 0).image
    draft = begin(Exemplar.of(image), (160, 160), draft=True)
    assert draft.fitted is None
    assert torch.equal(draft.refined().fitted.places, begin(Exemplar.of(image), (160, 160)).fitted.places)


def test_where_no_blocks_are_laid_none_is_seen_nor_laid_anew():
    beginning = begin(Exemplar.of(texture()), (40, 40), SMALL, start="windows")
    with pytest.raises(InputError, match="begins with no copies; start it as 'aligned'"):
        beginning.copied()
    with pytest.raises(InputError, match="begins with no blocks to lay anew"):
        beginning.anew(Box((0, 0), (8, 8)), seed=0)
    with pytest.raises(InputError, match="begins with no blocks to lay anew"):
        beginning.afresh(0)
    assert beginning.refined() is beginning


def test_blocks_are_not_kept_while_the_levels_improve_what_they_are_of(monkeypatch):
    starts, run = [], BlockStart.run

    def watched(self, draft):
        starts.append(ref(self))
        return run(self, draft)

    monkeypatch.setattr(BlockStart, "run", watched)
    alive = []
    optimize(Exemplar.of(texture()), (40, 44), settings=SMALL, callback=lambda p: alive.append(starts[0]() is not None))
    assert alive == [False] * 4
    beginning = begin(Exemplar.of(texture()), (40, 44), SMALL)
    assert torch.equal(improve(beginning.without_blocks()).image, improve(beginning).image)
    with pytest.raises(InputError, match="no blocks to lay anew"):
        beginning.without_blocks().anew(Box((0, 0), (8, 8)), seed=0)


LOOKED_FOR = ("hidden_seams", "find_repeats", "find_slant")


@pytest.mark.parametrize("side", [150, 400])
def test_what_is_looked_for_beforehand_is_asked_for_later(side, monkeypatch):
    """All of it by the same exemplar: what is laid at half the resolution asks for the ground there."""
    monkeypatch.setattr(laying, "LAID_FINE", 320**2)
    asked, exemplar = set[tuple[str, int]](), Exemplar.of(torch.rand(1, side, side))
    for module in (laying, import_module("kwatra.pieces.seams.gaps")):
        for name in LOOKED_FOR:
            find = getattr(module, name, None)
            if find is not None:
                monkeypatch.setattr(module, name, noted(asked, name, find))
    for look in looks(exemplar):
        look()
    wanted, _ = set(asked), asked.clear()
    assert {name for name, _ in wanted} == set(LOOKED_FOR)
    begin(exemplar, (64, 64))
    assert asked == wanted


def noted(asked, name, find):
    """A search that notes its name and of which canvas it was asked."""

    def found(exemplar):
        asked.add((name, id(exemplar.canvas)))
        return find(exemplar)

    return found


def test_blocks_of_a_large_exemplar_are_laid_at_half_the_resolution_with_seams_between_its_elements(monkeypatch):
    made, cut = MADE["coins"](280, 40, 0), {}
    exemplar = Exemplar.of(made.image)
    for pixels in (280**2, 280**2 - 1):
        monkeypatch.setattr(laying, "LAID_FINE", pixels)
        beginning = begin(exemplar, (300, 301), seed=1)
        assert beginning.factors == ((1, 1) if pixels == 280**2 else (2, 2))
        result = improve(beginning)
        assert result.where.shape == (2, 300, 301)
        assert (result.image - exemplar.canvas[(slice(None), *result.where)]).abs().mean() < 0.01
        flat = result.where[0] * 280 + result.where[1]
        cut[pixels] = cut_elements(made.numbers.numpy(), flat.numpy())["cut"]
    assert max(cut.values()) < 0.1  # .04 and .02


def stripes_across_stripes(height, width):
    """Bands of five tones down and across, which repeat each 48 px."""
    lines = torch.tensor([0.1] * 5 + [0.9] * 8 + [0.4] * 11 + [0.65] * 7 + [0.2] * 17)
    down, across = (lines[torch.arange(size) % 48] for size in (height, width))
    return (down[:, None] + 0.7 * across)[None] / 2


@pytest.mark.parametrize("seed", [0, 1])
def test_cloth_goes_on_line_by_line_from_one_cell(seed):
    exemplar, truth = Exemplar.of(stripes_across_stripes(48, 48)), stripes_across_stripes(110, 100)
    assert torch.allclose(optimize(exemplar, (110, 100), settings=SMALL, seed=seed).image, truth, atol=1e-5)
    wrapped = Settings(levels=SMALL.levels, wrap=True)
    assert torch.allclose(optimize(exemplar, (48, 96), settings=wrapped).image, truth[:, :48, :96], atol=1e-5)


def test_of_a_beginning_as_it_is_copied_nothing_is_improved():
    exemplar = Exemplar.of(texture())
    beginning = begin(exemplar, (70, 80), SMALL, seed=1)
    made = improve(beginning.as_copied())
    image, where = beginning.copied()
    assert torch.equal(made.image, image)
    assert torch.equal(made.where, where)
    assert made.stopped == "nothing was left to improve"
    assert not torch.equal(improve(beginning).image, image)


def test_of_what_goes_on_by_itself_no_level_is_done_unless_something_is_to_be_done_between():
    exemplar, told = Exemplar.of(stripes_across_stripes(48, 48)), []
    mask = torch.ones(60, 70, dtype=torch.bool)
    mask[10:20, 5:50] = False
    made = optimize(exemplar, (60, 70), settings=SMALL, mask=mask, callback=told.append)
    assert torch.allclose(made.image, torch.where(mask, stripes_across_stripes(60, 70), 0.0), atol=1e-5)
    assert made.energies == made.stages == []
    assert bool(((made.source[0] == -1) == ~mask).all())
    assert made.stopped == "nothing was left to improve"
    assert [p.fraction for p in told] == [1.0]
    darker = optimize(exemplar, (60, 70), settings=SMALL, between=lambda image, step: image / 2)
    assert float(darker.image.max()) < 0.6
    assert [row["factor"] for row in darker.energies] == [1] * len(darker.energies)


def test_what_is_woven_but_has_a_lattice_is_laid_in_step_with_it():
    line, tones = torch.arange(80), 0.5 + 0.3 * torch.rand(6, 6, generator=generator_of(1))
    tiles = torch.where((line % 14 < 2)[:, None] | (line % 14 < 2), 0.1, tones[line[:, None] // 14, line // 14])[None]
    assert find_weave(Exemplar.of(tiles)) is not None
    assert begin(Exemplar.of(tiles), (90, 90), SMALL).blocks.lattice is not None


@pytest.mark.parametrize(("size", "wrap"), [(20, False), (24, False), (24, True)])
def test_rows_go_on(size, wrap):
    """Lines of letters of many widths, each 24 or 29 px below the last; what wraps is 17 of 29, a little further."""
    letters, shape = Exemplar.of(MADE["letters"](128, size, 0).image), (500 if wrap else 256, 256)
    where = begin(letters, shape, Settings(wrap=wrap), seed=1).where.double()
    rows = find_rows(letters).closed(shape, (wrap, wrap))
    for axis in (1, 2):
        after = where.roll(-1, axis) if wrap else where.narrow(axis, 1, where.shape[axis] - 1)
        jump = after - where.narrow(axis, 0, after.shape[axis])
        jump[axis - 1] -= 1
        seam = jump.abs().amax(0) > 2
        assert 0 < float(seam.double().mean()) < 0.1
        assert float((rows.rest(jump[:, seam]).norm(dim=0) > 0.1 * rows.shortest).double().mean()) < 0.01


def test_cloth_that_terms_ask_something_of_is_laid_of_blocks():
    exemplar, wanted = Exemplar.of(stripes_across_stripes(48, 48)), torch.zeros(1, 60, 60)
    assert begin(exemplar, (60, 60), SMALL).blocks is None
    assert begin(exemplar, (60, 60), SMALL, SoftPixels(wanted, 0.1 * torch.ones(1, 60, 60))).blocks is not None


def test_elements_of_one_exemplar_are_made_whole_where_nothing_steers() -> None:
    stones = [MADE["stones"](96, 20, number).image for number in range(2)]
    one = Exemplar.of(stones[0])
    beginning = begin(one, (64, 64))
    assert beginning.fitted is not None
    assert beginning.where is not None
    warped, changed, *_ = beginning.fitted
    assert torch.equal(warped.round().long(), beginning.where)
    assert not torch.equal(warped, beginning.where.double())
    image, where = beginning.copied()
    on = (warped == where).all(0)
    assert on[~changed].all()
    assert torch.equal(image[:, on], stones[0][:, *where[:, on]])
    assert begin(Exemplar.of(stones), (64, 64)).fitted is None
    noise = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    assert begin(Exemplar.of(noise), (64, 64)).fitted is None


def test_maps_are_shown_as_colors_are_where_the_beginning_is_still_seen() -> None:
    one = Exemplar.of(MADE["stones"](96, 20, 0).image)
    beginning = begin(one, (64, 64))
    image, where = beginning.copied()
    assert torch.equal(beginning.shown(one.canvas, where), image)
    gray = beginning.shown(one.canvas[1:2], where)
    assert gray.shape == (1, 64, 64)
    assert float((gray - image[1:2]).abs().max()) < 1e-5
    other = where.roll(1, 1)
    shown, changed = beginning.shown(one.canvas, other), (other != where).any(0)
    assert torch.equal(shown[:, changed], one.canvas[:, *other][:, changed])


def test_loose_elements_are_made_whole_but_on_a_regular_lattice() -> None:
    row, column = torch.meshgrid(torch.arange(100), torch.arange(110), indexing="ij")
    far = ((row % 20 - 10) ** 2 + (column % 20 - 10) ** 2).sqrt()
    noise = 0.02 * torch.rand(3, 100, 110, generator=torch.Generator().manual_seed(0))
    dots = Exemplar.of((far < 6.5).float() * torch.tensor([0.8, 0.5, 0.3]).view(3, 1, 1) + noise)
    cells = find_cells(dots)
    assert cells is not None
    assert cells.loose
    laid = begin(dots, (80, 80))
    assert laid.fitted is None
    assert laid.blocks is not None
    assert begin(Exemplar.of(MADE["coins"](128, 32, 1).image), (80, 80)).fitted is not None  # three in a row by chance
