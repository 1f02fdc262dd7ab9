"""Renewal keeps elements whole: blocks hold them, and seams go around them."""

import numpy as np
import pytest
import torch
from made import MADE

import flow
from flow.animation.film.film import Film
from flow.animation.film.reading import Reading
from flow.animation.renewing.blocks import Blocks
from flow.animation.renewing.renewal import Renewal
from flow.animation.renewing.stock import COUNTS, MIXING, Coordinates
from flow.animation.sequence import Motion
from flow.animation.settings import Renewing
from flow.warps import pixel_coordinates
from kwatra import Exemplar
from kwatra.pieces import SeamCost, hidden_seams

SHAPE = (60, 64)


def stones(size: int = 24) -> Exemplar:
    return Exemplar.of(MADE["stones"](128, size, 0).image)


def test_blocks_hold_whole_elements_where_there_are_gaps_between_them() -> None:
    film = Film.of(stones())
    found = hidden_seams(film.strip)
    assert found is not None
    assert Renewal(film, SHAPE, Renewing(block=24)).blocks.sides == (round(2 * found.size),) * 2
    assert Renewal(film, SHAPE, Renewing(block=56)).blocks.sides == (56, 56)
    assert Renewal(film, SHAPE, Renewing(block=24), whole=True).blocks.sides == (24, 24)  # they are drawn whole anyway
    noise = torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0))
    assert Renewal(Film.of(Exemplar.of(noise)), SHAPE, Renewing(block=24)).blocks.sides == (24, 24)


@pytest.mark.parametrize(("texture", "drawn"), [("stones", True), ("letters", True), ("bricks", False)])
def test_blocks_need_hold_no_elements_that_are_drawn_whole(texture: str, drawn: bool) -> None:
    film, shape = Film.of(Exemplar.of(MADE[texture](128, 24, 0).image), turn=False), (96, 96)
    motion = Motion(film, flow.vortices(), shape, None, None, Renewing(block=20), 0)
    assert (motion.cells is not None) == drawn
    assert (motion.renewal.blocks.sides == (20, 20)) == drawn


@pytest.mark.parametrize("place", [(10, 60), (71, 5), (30, 70)])
def test_of_blocks_whose_colors_tell_nothing_the_one_is_found_whose_gaps_lie_where_gaps_are(
    place: tuple[int, int],
) -> None:
    film = Film.of(stones())
    found = hidden_seams(film.strip)
    here = pixel_coordinates((48, 48)) + torch.tensor(place).view(2, 1, 1)
    gray = film.strip.canvas.mean((1, 2))[:, None, None].expand(3, 48, 48)
    free, known = torch.Generator().manual_seed(0), torch.ones(1, 1, 48, 48)
    corners = []
    for hidden in (found, None):
        blocks = Blocks(film, (48, 48), hidden)
        content = blocks.seen(gray, here)
        assert torch.equal(content[:3], gray)
        corners += blocks.nearest(content[None], known, lambda rows: torch.zeros(len(rows), 128), free).tolist()
    assert corners[0] == list(place)
    assert corners[1] != list(place)


def test_a_seam_through_elements_costs_more_and_along_gaps_as_much_as_anywhere() -> None:
    exemplar = stones()
    stock, found = Coordinates(exemplar, 0.02, 1.2), hidden_seams(exemplar)
    assert found is not None
    plain, dearer = SeamCost(stock), stock.whole(found, (1.0, 1.0))
    generator = np.random.default_rng(0)
    s, t = generator.uniform(2, 125, (2, 3, 500)).astype(np.float32)
    depth = np.minimum(*(found.depth[tuple(np.rint(at[1::-1]).astype(int))] for at in (s, t)))
    for axis in range(2):
        once, more = (cost.seam(s, t, axis, 2) for cost in (plain, dearer))
        assert np.abs(more - once - MIXING * found.hides * 1.2 * COUNTS * depth).max() <= 1
        ahead = stock.beyond(s, axis, 1) + 0.3  # a copy that is bent a little goes on, and has no seam
        assert (dearer.seam(s, ahead, axis, 2) == plain.seam(s, ahead, axis, 2)).all()


@pytest.mark.parametrize("gaps", [True, False])
def test_a_block_goes_on_to_a_gap_around_it_where_there_are_gaps(gaps: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    film, shape = Film.of(stones()), (120, 120)
    if not gaps:
        monkeypatch.setattr("flow.animation.film.film.joints", lambda exemplar: None)
    source = (
        torch.rand(2, *shape, generator=torch.Generator().manual_seed(0)) * 120 + 2
    )  # nothing that is worth keeping
    renewal = Renewal(film, shape, Renewing(block=48))
    frame = renewal.begin(source, torch.ones(shape, dtype=torch.bool))
    renewal._renew(frame, [(36, 36)], torch.Generator().manual_seed(0))
    changed = (frame.source != source).any(0)
    changed[36 : 36 + renewal.blocks.sides[0], 36 : 36 + renewal.blocks.sides[0]] = False
    assert bool(changed.any()) == gaps
    assert renewal.film.hidden is None or not gaps or not bool(changed[:20].any())


def test_what_lies_in_another_picture_of_an_exemplar_does_not_go_on() -> None:
    pictures = Exemplar.of([stones().canvas, stones(20).canvas])
    read = Reading(pictures, "bilinear")
    owners = pictures.owner.unique()
    places = pixel_coordinates(pictures.owner.shape)
    assert len(owners[owners >= 0]) == 2
    for row in (5, pictures.owner.shape[0] - 12):
        part = places[:, row : row + 7]
        middle = pictures.owner[row + 3, part.shape[2] // 2]
        assert torch.equal(read.joined(part), read.usable(part) & (pictures.owner[row : row + 7] == middle))
