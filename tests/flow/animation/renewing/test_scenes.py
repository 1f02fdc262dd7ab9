"""A scene moves with all that it shows: what drifts in it is replaced from where it drifted from."""

from dataclasses import replace

import torch
from torch import Tensor

import flow
from flow.animation.film.film import Film
from flow.animation.renewing.scenes import home_of, places, places_onward
from flow.animation.sequence import Motion
from flow.animation.settings import VIDEO_PRESETS
from flow.warps import lookup, pixel_coordinates
from kwatra import Exemplar, Settings
from tests.flow.animation.film.test_film import cloud

SHAPE = (64, 72)
QUICK = replace(VIDEO_PRESETS["fast"], blocks=6, block=24, window=12, step=12)


def falling(frames: int = 12, speed: int = 2) -> Tensor:
    """A clip (1, frames, 64, 72) of clouds that fall by so many px a frame, from the dark into the light."""
    tall, light = cloud(64 + frames * speed, 72), torch.linspace(0, 1, 64).view(-1, 1)
    first = (frames - 1) * speed
    clouds = torch.stack([tall[:, first - speed * t : first - speed * t + 64] for t in range(frames)], 1)
    return 0.5 * clouds + 0.5 * light


def test_what_falls_in_a_scene_that_rests_is_replaced_from_where_it_began() -> None:
    film, homes = replace(Film.of(Exemplar.of(falling())), scene=True), []
    motion = Motion(film, flow.uniform(0.0), SHAPE, None, None, QUICK, 0)
    nearest = motion.renewal.blocks.nearest
    motion.renewal.blocks.nearest = lambda *given: homes.extend(given[4]) or nearest(*given)  # type: ignore
    state = motion.begin(None, Settings()).state
    began = places(film, state.source)
    for _ in range(10):
        state = motion.step(state).state
    assert state.place is not None
    assert torch.equal(state.place, began)
    assert float((places(film, state.source) - began)[1].max()) > 8
    spots = {home_of(began, (slice(y, y + 24), slice(x, x + 24))) for y in range(0, 41, 4) for x in range(0, 49, 4)}
    known = {tuple(spot.tolist()) for spot in spots}
    assert homes
    assert all(tuple(home.tolist()) in known for home in homes)


def test_places_move_with_the_flow_alone_and_what_enters_brings_its_own() -> None:
    film = replace(Film.of(Exemplar.of(falling())), scene=True)
    motion = Motion(film, flow.uniform(2.0), SHAPE, None, None, QUICK, 0)
    first = motion.begin(None, Settings()).state
    second = motion.step(first)
    assert second.state.place is not None
    before = places(film, first.source)
    assert torch.equal(second.state.place[:, :, 2:], before[:, :, :-2])
    fell = places(film, second.state.source)[1, :, 2:] - before[1, :, :-2]
    assert float(fell.median()) > 1
    entered = ~film.read.usable(first.source - torch.tensor([2.0, 0.0]).view(2, 1, 1))[:, :2]
    assert bool(entered.any())
    own = places(film, second.state.source)[:, :, :2]
    assert torch.equal(second.state.place[:, :, :2][:, entered], own[:, entered])


def test_places_that_tell_nothing_are_not_carried() -> None:
    film, source = replace(Film.of(Exemplar.of(falling())), scene=False), pixel_coordinates(SHAPE)
    still = lookup(torch.zeros(2, *SHAPE))
    assert places_onward(film, None, source, still, torch.ones(SHAPE, dtype=torch.bool)) is None


def test_the_home_of_a_block_is_that_of_most_of_its_pixels() -> None:
    x, y = pixel_coordinates(SHAPE)
    place = torch.stack([x + 11, y + 3])
    place[:, 12:18] = 0
    assert home_of(place, (slice(10, 34), slice(20, 44))).tolist() == [31.0, 13.0]
