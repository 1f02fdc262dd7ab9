import math
from unittest.mock import Mock

import numpy as np
import pytest
import torch

from kwatra import Exemplar, Settings, begin
from kwatra.pieces import visible_seams
from kwatra.scoring import pasted
from synth import synthesize
from synth.texture import search
from synth.texture.asked import Asked
from synth.texture.search import ALIKE, LEAST, LEAST_TORN, MOST, PARTS, PASTED, REFINED, TORN, Effort, Search
from synth.texture.work import LARGER, STILLS, Work

ONE = (Settings(),)
NOISE = Exemplar.of(torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0)))


@pytest.fixture
def ranked(monkeypatch):
    """Has beginnings ranked by a list of figures, and gives the images and source maps that were, in turn."""

    def by(figures):
        seen, left = [], iter(figures)
        figure = Mock(side_effect=lambda image: seen.append(image) or next(left))
        monkeypatch.setattr(search, "Ranking", lambda pictures, thorough: figure)
        for name in ("pasted", "visible_seams"):
            monkeypatch.setattr(search, name, lambda *_: 0.1)
        return seen

    return by


def searched(effort, seed=0, callback=None, size=(40, 44), ways=ONE):
    """What is made of white noise, and the beginnings that were tried, whether made from nothing or afresh."""
    begun, afresh = [], search.Beginning.afresh

    def make(settings, seed, draft):
        begun.append(begin(NOISE, size, settings, seed=seed, draft=draft))
        return begun[-1]

    def spied(beginning, seed):
        begun.append(afresh(beginning, seed))
        return begun[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search.Beginning, "afresh", spied)
        return Search(effort, ways, size, seed, callback, NOISE).best(make), begun


def like(one, other):
    """The share of pixels of which two source maps say the same."""
    return float((one == other).all(0).float().mean())


@pytest.mark.usefixtures("in_turn")
@pytest.mark.parametrize(("refined", "kept"), [((0.2, 0.2), 2), ((0.2, 0.1), 4)])
def test_the_drafts_of_least_rank_are_refined_and_of_these_the_better_is_made_and_of_equals_the_first(
    ranked, refined, kept
):
    seen = ranked([0.5, 0.4, 0.3, 0.6, 0.3, 0.3, *refined])
    made, begun = searched(Effort(6, 0))
    assert len(seen) == 6 + REFINED
    assert all(beginning.blocks.draft for beginning in begun)
    assert torch.equal(seen[6], begun[2].refined().copied()[0])
    assert torch.equal(seen[7], begun[4].refined().copied()[0])
    alike = [like(beginning.refined().copied()[1], made.where) for beginning in begun]
    assert alike.pop(kept) > 0.8
    assert max(alike) < 0.5


@pytest.mark.usefixtures("in_turn")
def test_parts_of_the_best_are_laid_anew_and_kept_where_the_whole_is_better(ranked, monkeypatch):
    made_of, anew = [], search.Beginning.anew

    def spied(beginning, part, seed):
        made_of.append((beginning, anew(beginning, part, seed)))
        return made_of[-1][1]

    monkeypatch.setattr(search.Beginning, "anew", spied)
    monkeypatch.setattr(search.Beginning, "refined", lambda self: self)
    figures = 0.5, 0.5 - ALIKE
    rounds = [*[0.6] * (PARTS - 1), 0.3], [0.3] * PARTS  # the last part of the first is better
    ranked([*figures, *figures[::-1], *rounds[0], *rounds[1]])
    made, begun = searched(Effort(2, 2))
    parents, children = zip(*made_of, strict=True)
    assert len(begun) == 2
    assert all(parent is begun[1] for parent in parents[:PARTS])
    assert all(parent is children[PARTS - 1] for parent in parents[PARTS:])
    assert like(made.where, children[PARTS - 1].copied()[1]) > 0.8


@pytest.mark.usefixtures("in_turn")
def test_where_first_tries_differ_much_others_are_made_in_place_of_parts(ranked):
    seen = ranked([0.5, 0.5 - 2.1 * ALIKE, 0.6, 0.3, 0.4, 0.3, 0.4])
    made, begun = searched(Effort(2, 3))
    assert len(seen) - REFINED == len(begun) == 5
    assert like(made.where, begun[3].refined().copied()[1]) > 0.8


@pytest.mark.usefixtures("in_turn")
def test_first_tries_are_begun_in_every_way_and_others_in_that_of_the_best(ranked):
    ranked([0.5, 0.6, 0.5, 0.5 - 2.1 * ALIKE, 0.4, 0.4, 0.4, 0.4])
    one, other = Settings(), Settings(block=0.7)
    _, begun = searched(Effort(4, 2), ways=(one, other))
    assert [beginning.task.settings for beginning in begun] == [one, other, one, other, other, other]


@pytest.mark.parametrize("threads", [1, 3])
def test_tries_made_afresh_are_those_that_would_be_made_from_nothing(monkeypatch, threads):
    torch.set_num_threads(threads)
    ways = Settings(), Settings(block=0.7)
    afresh, _ = searched(Effort(5, 2), ways=ways, seed=3)
    made = []

    def from_nothing(beginning, seed):
        made.append(begin(NOISE, (40, 44), beginning.task.settings, seed=seed, draft=beginning.blocks.draft))
        return made[-1]

    monkeypatch.setattr(search.Beginning, "afresh", from_nothing)
    anyhow, _ = searched(Effort(5, 2), ways=ways, seed=3)
    assert made
    assert torch.equal(afresh.image, anyhow.image)
    assert torch.equal(afresh.where, anyhow.where)


@pytest.mark.usefixtures("in_turn")
def test_how_much_first_tries_differ_does_not_count_from_way_to_way(ranked, monkeypatch):
    parts = []
    monkeypatch.setattr(search.Beginning, "anew", lambda self, part, seed: parts.append(part) or self)
    ranked([0.5, 0.9, 0.5, 0.9, 0.5, 0.5, *[0.6] * PARTS])
    searched(Effort(4, 1), ways=(Settings(), Settings(block=0.7)))
    assert len(parts) == PARTS


@pytest.mark.usefixtures("in_turn")
@pytest.mark.parametrize(("effort", "weight"), [(Effort(2, 0), PASTED[0]), (Effort(2, 1), PASTED[1])])
def test_a_figure_counts_what_is_pasted_and_what_is_torn(monkeypatch, effort, weight):
    figures = []
    monkeypatch.setattr(search, "Ranking", lambda pictures, thorough: Mock(return_value=0.5))
    _, begun = searched(effort, callback=lambda p: figures.append(p.energy))
    for figure, beginning in zip(figures[:2], begun, strict=True):
        where = beginning.copied()[1]
        expected = (
            0.5 + weight * pasted(where, 32 * 32) ** 2 + TORN * math.log(visible_seams(NOISE, where) + LEAST_TORN)
        )
        assert figure == pytest.approx(expected)


@pytest.mark.usefixtures("in_turn")
def test_blocks_are_larger_in_every_other_first_try(monkeypatch):
    noise, begun, afresh = (
        torch.rand(1, 32, 32, generator=torch.Generator().manual_seed(0)),
        [],
        search.Beginning.afresh,
    )

    def spied(*args, settings, **more):
        begun.append(settings.block)
        return begin(*args, settings, **more)

    def made_afresh(beginning, seed):
        begun.append(beginning.task.settings.block)
        return afresh(beginning, seed)

    monkeypatch.setattr("kwatra.begin", spied)
    monkeypatch.setattr(search.Beginning, "afresh", made_afresh)
    for preset in ("default", "best"):
        synthesize(noise, (32, 32), levels=((1, 8),), preset=preset)
        first = STILLS[preset].first
        assert begun[:first] == ([0.5, LARGER] * first)[:first]
        begun.clear()
    synthesize(noise, (32, 32), levels=((1, 8),), preset="fast")
    assert begun == [0.5]


def test_larger_stills_begin_with_fewer_tries_and_best_with_at_most_eight_times_as_many():
    noise = torch.rand(1, 32, 32)
    efforts = {
        preset: [Work.of(Asked.of(noise, (side, side)), preset=preset).effort for side in range(64, 3000, 37)]
        for preset in ("fast", "default", "best")
    }
    assert {effort.tries for effort in efforts["fast"]} == {1}
    assert sorted({effort.tries for effort in efforts["default"]}) == [1, *(n + REFINED for n in range(2, 7))]
    for default, best in zip(efforts["default"], efforts["best"], strict=True):
        assert default.tries < best.tries < 8 * default.tries
    for several in efforts.values():
        tries = [effort.tries for effort in several]
        assert tries == sorted(tries, reverse=True)


def test_parts_lie_everywhere_and_are_a_quarter_to_half_as_long_as_the_output(ranked, monkeypatch):
    parts, size, rounds = [], (100, 60), 100
    monkeypatch.setattr(search.Beginning, "anew", lambda self, part, seed: parts.append(part) or self)
    ranked([0.5] * (2 + rounds * PARTS))
    searched(Effort(1, rounds), size=size)
    assert len(parts) == rounds * PARTS
    times = np.zeros(size)
    for part in parts:
        times[tuple(slice(a, b) for a, b in zip(part.start, part.stop, strict=True))] += 1
        for a, b, n in zip(part.start, part.stop, size, strict=True):
            assert 0 <= a < b <= n
            assert b - a <= MOST * n + 1
            assert b - a >= LEAST * n - 1 or a == 0 or b == n
    assert times.min() > 0
    assert times.max() < len(parts) / 2


def test_of_an_exactly_periodic_picture_no_part_is_laid_anew():
    tiles = np.tile(np.kron(np.eye(2), np.ones((8, 8))), (3, 3)).astype(np.float32)
    told = []
    made = synthesize(tiles, (80, 80), preset="best", callback=told.append)
    np.testing.assert_allclose(made.image[:64, :64], made.image[16:, 16:], atol=1e-6)
    assert len([p for p in told if p.fraction < 1]) == STILLS["best"].first
    assert told[-1].fraction == 1


def test_progress_is_told_of_each_try_and_of_the_rest():
    told = []
    searched(Effort(2, 1), callback=told.append)
    fractions = [p.fraction for p in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1)
    assert {p.attempt for p in told} == {1, 2, 3, 4, 5}
    assert {p.tries for p in told} == {5}


@pytest.mark.parametrize(("pixels", "together"), [(40 * 44 * 2, 1), (40 * 44 * 2 - 1, 2)])
def test_beginnings_are_tried_side_by_side_where_memory_allows_and_the_same_is_kept(pixels, together, monkeypatch):
    used = []
    monkeypatch.setattr("synth.texture.runs.BESIDE", pixels)
    rank = Mock(side_effect=lambda image: used.append(torch.get_num_threads()) or float(image.mean()))
    monkeypatch.setattr(search, "Ranking", lambda pictures, thorough: rank)
    made = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        made.append(searched(Effort(3, 1), seed=2)[0].image)
    assert used == [1] * (3 + REFINED + PARTS) + [together] * (3 + REFINED + PARTS)
    assert torch.equal(*made)
