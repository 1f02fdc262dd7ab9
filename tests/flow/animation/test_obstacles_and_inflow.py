"""Textures that flow around obstacles, and into empty frames."""

from dataclasses import replace

import pytest
import torch
from torch import Tensor
from wall import SHAPE, animated, brick

import flow

STONE = flow.disc_mask(SHAPE, (36.0, 32.0), 11.0)


def test_no_texture_is_behind_an_obstacle() -> None:
    frames = animated(flow.around(flow.uniform(2.0), STONE), mask=STONE)
    for frame in frames:
        assert torch.equal(frame.state.inside, STONE)
        assert float(frame.image[:, ~STONE].abs().max()) == 0
        assert bool((frame.source[0] == torch.where(STONE, 0, -1)).all())
        assert float(frame.image[:, STONE].min()) > 0
        assert bool(((frame.where >= 0) & (frame.where < 80)).all())


def test_what_is_behind_an_obstacle_changes_not_one_bit() -> None:
    field = flow.around(flow.uniform(1.7), STONE)
    states = [frame.state for frame in animated(field, 3, mask=STONE)]
    for hidden in (states[1].source + 0.6, torch.rand(2, *SHAPE) * 80, torch.full((2, *SHAPE), torch.nan)):
        source, image = (torch.where(STONE, seen, hidden[:1]) for seen in (states[1].source, states[1].image))
        spoiled = replace(states[1], source=source, image=image)
        again = animated(field, 3, mask=STONE, after=spoiled)[-1]
        assert torch.equal(again.state.source[:, STONE], states[2].source[:, STONE])
        assert torch.equal(again.state.image[:, STONE], states[2].image[:, STONE])
    given = brick(140)[:, :64, :72]
    shown = [
        animated(field, 2, mask=STONE, first=torch.where(STONE, given, value))[-1].image for value in (0.0, 0.5, 1.0)
    ]
    assert torch.equal(shown[0], shown[1])
    assert torch.equal(shown[0], shown[2])


def test_an_obstacle_may_move() -> None:
    def mask(number: int) -> Tensor:
        return flow.disc_mask(SHAPE, (20.0 + 8 * number, 32.0), 10.0)

    for frame in animated(flow.uniform(1.0), 4, mask=mask):
        assert torch.equal(frame.state.inside, mask(frame.state.number))
        assert float(frame.image[:, frame.state.inside].min()) > 0


@pytest.mark.parametrize("speed", [0.3, 1.4, 2.0, 5.0])
def test_texture_enters_an_empty_frame_as_fast_as_it_flows(speed: float) -> None:
    frames = animated(flow.uniform(speed), 9, enter="left")
    assert not bool(frames[0].state.inside.any())
    assert float(frames[0].image.abs().max()) == 0
    for frame in frames:
        columns = frame.state.inside.sum(1)
        assert int(columns.min()) == int(columns.max())
        assert abs(int(columns[0]) - speed * frame.state.number) <= 1.3
        assert bool(frame.state.inside[:, : int(columns[0])].all())
    wide = frames[-1].image[:, frames[-1].state.inside]
    assert speed < 1 or float(wide.std()) > 0.5 * float(brick().std())


@pytest.mark.parametrize(
    ("side", "angle", "corner"),
    [("right", 180, (32, -1)), ("top", 90, (0, 36)), ("bottom", 270, (-1, 36)), ("all", 180, (32, -1))],
)
def test_texture_enters_from_any_side(side: str, angle: float, corner: tuple[int, int]) -> None:
    inside = animated(flow.uniform(3.0, angle), 3, enter=side)[-1].state.inside
    assert bool(inside[corner])
    assert int(inside.sum()) == 6 * (SHAPE[0] if angle == 180 else SHAPE[1])


def test_what_enters_flows_around_an_obstacle_and_leaves_no_wake() -> None:
    frames = animated(flow.around(flow.uniform(6.0), STONE), 24, enter="left", mask=STONE)
    grown = [int(frame.state.inside.sum()) for frame in frames]
    assert grown[:16] == sorted(grown[:16])
    assert grown[-1] > 0.99 * int(STONE.sum())
    assert not any(bool((frame.state.inside & ~STONE).any()) for frame in frames)
    early = frames[6].state.inside
    assert bool(early[2, 20])
    assert not bool(early[:, 45:].any())


def test_without_motion_an_empty_frame_stays_empty_even_beside_an_obstacle() -> None:
    state = flow.State(0, torch.zeros(2, *SHAPE), STONE & (torch.arange(SHAPE[1]) < 30), torch.zeros(1, *SHAPE))
    still = flow.Field(lambda t, shape: torch.zeros(2, *shape), steady=True)
    last = animated(still, 4, enter="left", mask=STONE, after=state)[-1]
    assert torch.equal(last.state.inside, state.inside)
