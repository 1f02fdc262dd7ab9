"""Blocks laid turned: what a frame shows at a spot, seen as it lies in the exemplar, and back."""

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from flow.animation.film.film import Film
from flow.animation.renewing.placing import bounds, radians, reach, settled, shift_of, turn_of, upright
from flow.animation.renewing.renewal import Renewal
from flow.animation.renewing.stock import COUNTS, TURNS, Coordinates
from flow.animation.settings import Renewing
from flow.warps import warp
from kwatra import Exemplar
from kwatra.pieces import Box, Patch
from kwatra.pieces.seams.stock import beside

SHAPE, SIZE, SPOT = (60, 70), 17, (slice(20, 37), slice(30, 47))
TURNED = [0, 300, -1500, TURNS // 2]


def smooth(side: int = 96) -> Tensor:
    noise = torch.rand(1, 1, side // 8, side // 8, generator=torch.Generator().manual_seed(0))
    return torch.nn.functional.interpolate(noise, (side, side), mode="bicubic", align_corners=True)[0].clamp(0, 1)


def shown(patch: Patch, rows: slice, columns: slice) -> Tensor:
    lines = [np.arange(part.start, part.stop) - by for part, by in zip((rows, columns), patch.shift, strict=True)]
    return torch.from_numpy(Coordinates(Exemplar.of(smooth()), 0.1, 1.0).places(patch.number, lines)[:2])


def test_copies_turned_to_both_sides_of_half_a_turn_are_turned_by_half_a_turn() -> None:
    angle = torch.tensor([[math.radians(178), math.radians(-178)], [0.0, 0.0]])
    assert abs(turn_of(angle, torch.tensor([[True, True], [False, False]]))) == TURNS // 2
    assert turn_of(angle, torch.zeros(2, 2, dtype=torch.bool)) == 0
    assert radians(turn_of(torch.full((3, 3), 0.4), torch.ones(3, 3, dtype=torch.bool))) == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize("turn", TURNED)
def test_a_turned_block_stays_within_its_reach(turn: int) -> None:
    patch = Patch(turn, shift_of(torch.tensor([40, 30]), SPOT, turn), Box((20, 30), (SIZE, SIZE)))
    place = shown(patch, *SPOT)
    middle = torch.tensor([40 + (SIZE - 1) / 2, 30 + (SIZE - 1) / 2])
    assert torch.allclose(place.mean((1, 2)), middle, atol=1e-3)
    assert float((place - middle.view(2, 1, 1)).abs().max()) <= (SIZE - 1) / 2 + reach(SIZE, turn) + 1e-3
    assert reach(SIZE, turn) <= SIZE * (math.sqrt(2) - 1) / 2 + 2


@pytest.mark.parametrize("turn", TURNED)
def test_what_is_laid_turned_is_seen_upright_again(turn: int) -> None:
    patch = Patch(turn, shift_of(torch.tensor([40, 30]), SPOT, turn), Box((20, 30), (SIZE, SIZE)))
    frame = warp(smooth(), shown(patch, slice(0, SHAPE[0]), slice(0, SHAPE[1])), "bicubic")
    usable = torch.ones(SHAPE, dtype=torch.bool)
    usable[:24] = False
    seen, known = upright(frame, usable, SPOT, turn)
    assert float((seen - smooth()[:, 30:47, 40:57]).abs().max()) < 0.02
    assert 0.6 < float(known.float().mean()) < 0.9
    everywhere, corner = torch.ones(SHAPE, dtype=torch.bool), (slice(0, SIZE), slice(0, SIZE))
    assert bool(upright(frame, everywhere, corner, turn)[1].all()) == (turn in (0, TURNS // 2))


@pytest.mark.parametrize("turn", TURNED)
def test_a_block_is_moved_onto_the_copy_that_is_there(turn: int) -> None:
    patch = Patch(turn, shift_of(torch.tensor([40, 30]), SPOT, turn), Box((20, 30), (SIZE, SIZE)))
    there = shown(patch, *SPOT) + torch.tensor([0.3, -0.4]).view(2, 1, 1)
    usable = torch.ones(SIZE, SIZE, dtype=torch.bool)
    moved = Patch(turn, settled(patch, there - shown(patch, *SPOT), usable), patch.box)
    assert torch.allclose(shown(moved, *SPOT), there, atol=1e-3)
    assert settled(patch, torch.full((2, SIZE, SIZE), 9.0), usable) == patch.shift
    usable[1:] = False
    assert settled(patch, there - shown(patch, *SPOT), usable) == patch.shift


def test_a_turned_copy_that_lacks_a_part_is_continued_as_it_is_turned() -> None:
    noise = torch.rand(1, 120, 120, generator=torch.Generator().manual_seed(1))
    exemplar = Exemplar.of(torch.nn.functional.avg_pool2d(noise[None], 3, 1, 1)[0])
    renewal = Renewal(
        Film.of(exemplar, turn=True), (40, 40), Renewing(block=20, window=8, step=4, usage=0.0, tones=0.0)
    )
    turn = 700
    patch = Patch(turn, shift_of(torch.tensor([50, 50]), (slice(10, 30), slice(10, 30)), turn), Box((0, 0), (1, 1)))
    whole = shown(patch, slice(0, 40), slice(0, 40))
    source = whole.clone()
    source[:, 16:24, 14:25] = -500.0
    after, *_ = renewal(source, torch.ones(40, 40, dtype=torch.bool), torch.Generator().manual_seed(0))
    assert float((after - whole).abs().max()) < 0.1


def test_seams_of_a_block_cost_what_they_do_one_by_one() -> None:
    rng = np.random.default_rng(0)
    stock = Coordinates(Exemplar.of(smooth()), 0.1, 1.0)
    old, new = (rng.uniform(0, 30, (3, 7, 9)).astype(np.float32) for _ in range(2))
    for axis, costs in enumerate(stock.matches(old, new)):
        p, q = beside(axis, 2)
        over, under = stock.beyond(old[p], axis, 1), stock.beyond(old[q], axis, -1)
        shows = stock.colors
        expected = (
            stock.distance(shows(old[p]), shows(new[p])) + stock.distance(shows(over), shows(new[q])),
            stock.distance(shows(old[q]), shows(new[q])) + stock.distance(shows(under), shows(new[p])),
        )
        for cost, other in zip(costs, expected, strict=True):
            assert np.abs(cost - other).max() <= 1  # of COUNTS to a deviation
            assert cost.max() > COUNTS


def test_bounds_are_the_least_part_that_holds_what_is_taken() -> None:
    take = torch.zeros(8, 9, dtype=torch.bool)
    take[2, 5] = take[4, 3] = True
    assert bounds(take, (slice(10, 18), slice(20, 29))) == (slice(12, 15), slice(23, 26))
