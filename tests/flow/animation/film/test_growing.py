"""Texture that may turn: grown beyond the frame, it goes round and round and nothing of it is renewed."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from made import MADE
from skimage import data
from torch import Tensor

import flow
from flow.animation.asked import film_of
from flow.animation.carrying import angles
from flow.animation.film import Film
from flow.animation.film.growing import grown
from kwatra import Exemplar, Settings, optimize

SHAPE = (40, 56)
QUICK = Settings(seams=2, iterations=1)


def gravel(side: int = 96) -> Tensor:
    return torch.from_numpy(data.gravel()[:side, :side].astype(np.float32) / 255)[None]


def bricks() -> Tensor:
    return torch.from_numpy(data.brick()[:96, :96].astype(np.float32) / 255)[None]


def test_it_is_the_exemplars_pixels_and_holds_the_turned_frame() -> None:
    exemplar = Exemplar.of(gravel())
    film = grown(Film.of(exemplar, Exemplar.of(1 - gravel())), SHAPE, QUICK, 0)
    rows, columns = film.strip.shape
    assert rows >= 2 * SHAPE[0] - 1 or rows**2 >= 40**2 + 56**2
    assert columns**2 >= 40**2 + 56**2
    assert film.placed is not None
    assert film.also is not None
    assert torch.equal(film.strip.canvas, gravel()[:, film.placed[0], film.placed[1]])
    assert torch.equal(film.also.canvas, 1 - film.strip.canvas)
    assert film.pitch == rows
    x, y = film.middle(SHAPE)[:, [0, -1], [0, -1]]
    assert (x.sum() - (columns - 1)).abs() <= 1
    assert (y.sum() - (rows - 1)).abs() <= 1


def test_elements_that_were_made_whole_are_shown_as_the_still_shows_them() -> None:
    exemplar, shape = Exemplar.of(MADE["stones"](96, 24, 0).image), (64, 64)
    film = grown(Film.of(exemplar, exemplar, turn=True), shape, QUICK, 0)
    still = optimize(exemplar, film.strip.shape, settings=replace(QUICK, even=0.0))
    assert film.placed is not None
    assert film.also is not None
    assert torch.equal(film.strip.canvas, film.also.canvas)
    copied = exemplar.canvas[:, *film.placed]
    between = (film.strip.canvas - copied).abs().amax(0) > 1e-6
    assert 0.01 < float(between.float().mean()) < 0.5
    assert torch.equal(film.strip.canvas[:, between], still.image[:, between])


def test_only_what_prefers_no_direction_turns_unless_asked() -> None:
    assert Film.of(Exemplar.of(gravel())).turning > 0
    assert Film.of(Exemplar.of(bricks())).turning == 0
    assert Film.of(Exemplar.of(gravel()), turn=False).turning == 0
    assert Film.of(Exemplar.of(bricks()), turn=True).turning > 0
    film = Film.of(Exemplar.of(bricks()))
    assert grown(film, SHAPE, QUICK, 0) is film


def sheared(t: float, shape: tuple[int, int]) -> Tensor:
    """A rotation that is sheared a little."""
    return flow.rotation(2.0)(t, shape) + 0.2 * flow.shear(2.0)(t, shape)


@pytest.mark.parametrize(
    ("field", "turns"),
    [
        (flow.rotation(2.0), True),
        (flow.uniform(2.0), True),
        (flow.Field(sheared), True),
        (flow.shear(2.0), False),
        (flow.vortices(2.0), False),
        (flow.sink(2.0), False),
    ],
    ids=["rotation", "uniform", "sheared", "shear", "vortices", "sink"],
)
def test_copies_turn_where_the_flow_hardly_bends_them(field: flow.Field, turns: bool) -> None:
    assert (film_of(gravel(), None, None, field, SHAPE).turning > 0) == turns
    assert film_of(gravel(), None, True, field, SHAPE).turning > 0
    assert film_of(bricks(), None, None, field, SHAPE).turning == 0


@pytest.mark.parametrize("make", [flow.animate, flow.loop])
def test_turning_frames_renew_nothing_and_show_the_exemplar_where_they_say(make) -> None:  # type: ignore[no-untyped-def]
    frames = list(make(gravel(), flow.rotation(3.0), SHAPE, frames=8, synthesis=QUICK, turn=True))
    sharp = [sum(float(frame.image.diff(dim=axis).abs().mean()) for axis in (1, 2)) for frame in frames]
    assert min(sharp) > 0.85 * sharp[0]
    shown = gravel()[:, frames[0].where[0], frames[0].where[1]]
    assert float((shown - frames[0].image).abs().mean()) < 0.01  # but for softened seams, which are the still's own
    assert torch.equal(frames[0].source[1:], frames[0].where)
    if make is flow.animate:
        assert all(frame.energies[0]["renewed"] < 0.02 for frame in frames[1:])
        angle = -3.0 / np.hypot(19.5, 27.5) * 7
        assert float(angles(frames[-1].state.source).median()) == pytest.approx(angle, rel=0.05)


def test_asking_for_directions_keeps_them() -> None:
    *_, last = flow.animate(gravel(), flow.rotation(3.0), SHAPE, frames=8, synthesis=QUICK, turn=False)
    assert abs(float(angles(last.state.source).median())) < 0.3
