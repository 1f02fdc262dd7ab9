"""Loops: the last frame leads into the first as any other leads into the next."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import torch
from made import GROUND, MADE
from skimage import data
from torch import Tensor

import flow
from flow.animation import looping, sequence
from flow.animation.settings import VIDEO_PRESETS, Renewing
from kwatra import InputError
from kwatra.pieces import SeamCost

SHAPE = (56, 60)
QUICK = Renewing(blocks=6, block=32, window=16, step=8)
FRAMES = 12


def gravel() -> Tensor:
    return torch.from_numpy(data.gravel()[:80, :80].astype(np.float32) / 255)[None]


def looped(field: flow.Field, frames: int = FRAMES, **how) -> list[flow.Frame]:
    return list(flow.loop(gravel(), field, SHAPE, frames=float(frames), renewing=QUICK, **how))


@cache
def turning() -> list[flow.Frame]:
    """A loop that several tests look at."""
    return looped(flow.rotation(1.5))


def differences(images: list[Tensor], field: flow.Field) -> list[float]:
    """Between each frame and the warped one before; the last is that of frame 0 after the last."""
    result = []
    for number, (before, after) in enumerate(pairwise([*images, images[0]])):
        look = flow.lookup(field(number, SHAPE))
        known = look.known[6:-6, 6:-6]
        change = (after - flow.warp(before, look.coordinates))[0, 6:-6, 6:-6].abs()
        result.append(float(change[known].mean()))
    return result


@pytest.mark.parametrize("name", ["rotation", "uniform:30"])
def test_the_join_is_a_pair_of_frames_like_any_other(name: str) -> None:
    field = flow.named(name, speed=1.5)
    images = [frame.image for frame in (turning() if name == "rotation" else looped(field))]
    assert len(images) == FRAMES
    *others, join = differences(images, field)
    assert join <= 1.15 * max(others)
    plain = list(flow.animate(gravel(), field, SHAPE, frames=FRAMES, renewing=QUICK))
    assert differences([frame.image for frame in plain], field)[-1] > 1.7 * join


def test_the_loop_moves_and_stays_texture() -> None:
    field = flow.rotation(1.5)
    frames = turning()
    for a, b in pairwise(frames):
        assert not torch.equal(a.image, b.image)
        assert float(b.image.std()) == pytest.approx(float(gravel().std()), rel=0.25)
    errors = [flow.end_point_error(flow.seen(a.image, b.image), field(0, SHAPE)) for a, b in pairwise(frames)]
    assert sum(errors) / len(errors) < 0.5


def test_what_is_shown_is_where_the_map_says() -> None:
    for frame in turning():
        seen = gravel()[0, frame.source[1], frame.source[2]]
        assert float((frame.image[0] - seen).abs().median()) < 0.1


def test_the_first_half_is_the_animations_own() -> None:
    plain = list(flow.animate(gravel(), flow.rotation(1.5), SHAPE, frames=6, renewing=QUICK))
    for a, b in zip(plain, turning()[:6], strict=True):
        assert torch.equal(a.image, b.image)


def test_going_on_after_a_state_gives_the_same_bits() -> None:
    field, frames = flow.noise(1.5, period=8), 8
    whole = looped(field, frames)
    for last in (2, 5):  # before the half and after it
        rest = looped(field, frames, after=whole[last].state)
        assert [frame.state.number for frame in rest] == list(range(last + 1, frames))
        for a, b in zip(whole[last + 1 :], rest, strict=True):
            assert torch.equal(a.image, b.image)
            assert torch.equal(a.state.source, b.state.source)


def test_nothing_is_behind_an_obstacle() -> None:
    stone = flow.disc_mask(SHAPE, (30.0, 28.0), 9.0)
    for frame in looped(flow.around(flow.uniform(1.5), stone), 8, mask=stone):
        assert float(frame.image[:, ~stone].abs().max()) == 0
        assert float(frame.image[:, stone].min()) >= float(gravel().min())


@pytest.mark.parametrize("frames", [2, 3, 4, 5])
def test_short_loops_are_made_too(frames: int) -> None:
    assert [frame.state.number for frame in looped(flow.uniform(1.0), frames)] == list(range(frames))


def test_a_loop_of_one_frame_is_refused() -> None:
    with pytest.raises(InputError, match="a loop is to have 1 frames; give a whole number, at least 2"):
        flow.loop(gravel(), flow.uniform(), SHAPE, frames=1)
    with pytest.raises(InputError, match="a flow is 30x20 but the frame 60x56"):
        flow.loop(gravel(), flow.sampled(torch.zeros(2, 20, 30)), SHAPE, frames=8)


def test_seams_between_the_ways_ahead_and_back_lead_through_few_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    stones = MADE["stones"](96, 24, 0)
    monkeypatch.setattr(sequence, "cells_that_flow", lambda _: None)  # which would draw them whole

    def through() -> int:
        """How many pairs of neighbors are parted within stones, in all frames of the turns of two loops."""
        count = 0
        for seed in range(2):
            for frame in list(flow.loop(stones.image, flow.vortices(2.0), (64, 64), frames=12, seed=seed))[7:]:
                number = stones.numbers[tuple(frame.where)]
                for axis in range(2):
                    one, other = (number.narrow(axis, first, 63) for first in range(2))
                    count += int(((one != other) & (one != GROUND) & (other != GROUND)).sum())
        return count

    now = through()
    monkeypatch.setattr(looping._Back, "_cost", lambda self, mosaic, sources: SeamCost(mosaic))
    assert now < 0.5 * through()


def test_both_ways_of_a_scene_pass_over_into_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    light = torch.linspace(0, 1, 72).expand(1, 8, 64, 72)  # from dark to bright, and never the same
    clip = light + 0.02 * torch.rand(1, 8, 64, 72, generator=torch.Generator().manual_seed(0))

    def edge() -> float:
        """The largest step between neighbors in the frames of the turn."""
        frames = list(flow.loop(clip, flow.uniform(2.0), (64, 72), frames=16, renewing=VIDEO_PRESETS["fast"]))[9:]
        return max(float(frame.image.diff(dim=axis).abs().max()) for frame in frames for axis in (1, 2))

    now = edge()
    monkeypatch.setattr(looping._Back, "_feathered", lambda self, turned, ahead, back: turned.float())
    assert now < 0.3 * edge()
