"""Videos that flow: their texture lives on as it did, from page to page, and is renewed before its pages end."""

from dataclasses import replace
from itertools import pairwise

import pytest
import torch
import torch.nn.functional as F
from torch import Tensor

import flow
from flow.animation.film.drift import drift
from flow.animation.film.film import Film
from flow.animation.renewing.aging import Aging
from flow.animation.settings import VIDEO_PRESETS, Renewing
from flow.warps import pixel_coordinates
from kwatra import Exemplar

SHAPE = (48, 56)
QUICK = replace(VIDEO_PRESETS["fast"], blocks=4, block=24, window=12, step=12)
PLAIN = Renewing(blocks=0, stiffness=0, inertia=0, block=24, window=12)
"""Neither renewed nor mixed: what was there, where the flow has brought it."""


def cloud(height: int, width: int, seed: int = 0) -> Tensor:
    noise = torch.rand(1, 1, height, width, generator=torch.Generator().manual_seed(seed))
    smooth = F.avg_pool2d(F.avg_pool2d(noise, 5, 1, 2), 3, 1, 1)[0]
    return (smooth - smooth.amin()) / (smooth.amax() - smooth.amin())


def drifting(frames: int = 8, speed: int = 2) -> Tensor:
    """A clip (1, frames, 64, 72) of clouds that move by so many px a frame to the right."""
    wide = cloud(64, 72 + frames * speed)
    first = (frames - 1) * speed
    return torch.stack([wide[..., first - speed * t : first - speed * t + 72] for t in range(frames)], 1)


def living(frames: int = 9) -> Tensor:
    """A clip (1, frames, 64, 72) of clouds that turn into other ones in place."""
    one, other = cloud(64, 72), cloud(64, 72, 1)
    return torch.stack([torch.lerp(one, other, t / (frames - 1)) for t in range(frames)], 1)


def animated(clip: Tensor, field: flow.Field, frames: int = 4, **how) -> list[flow.Frame]:
    return list(flow.animate(clip, field, SHAPE, frames=frames, **{"renewing": QUICK, **how}))


def test_a_picture_is_a_film_of_one_page() -> None:
    image = cloud(40, 50)
    film, places = Film.of(Exemplar.of(image)), pixel_coordinates((40, 50))
    assert film.pages == 1
    assert film.strip.canvas is film.described.canvas
    assert torch.equal(film.onward(places), places)
    assert bool(film.left.isinf().all())
    still, video = (animated(given, flow.rotation(2.0), renewing=None) for given in (image, image[:, None]))
    for one, other in zip(still, video, strict=True):
        assert torch.equal(one.image, other.image)
        assert torch.equal(one.where, other.where[1:])
        assert other.source.shape[0] == 4
        assert not bool(other.where[0].any())


def test_drift_is_the_motion_of_what_only_moves_and_none_where_nothing_moves() -> None:
    inner = (slice(None), slice(None), slice(16, -16), slice(16, -16))
    moving = drift(Exemplar.of(drifting()))[inner]
    assert float((moving - torch.tensor([2.0, 0.0]).view(2, 1, 1, 1)).abs().max()) < 0.3
    assert float(drift(Exemplar.of(cloud(64, 72)[:, None].expand(-1, 5, -1, -1))).abs().max()) == 0
    assert float(drift(Exemplar.of(torch.rand(1, 3, 12, 40))).abs().max()) == 0
    assert float(drift(Exemplar.of(torch.rand(1, 1, 40, 40))).abs().max()) == 0


def test_what_drifts_is_followed_from_page_to_page() -> None:
    film = Film.of(Exemplar.of(drifting()))
    places = pixel_coordinates((64, 72))[:, 20:44, 20:36]
    before, after = film.read(places), film.read(film.onward(places))
    assert float((after - before).abs().mean()) < 0.05 * float(before.std())
    assert torch.equal(film.onward(places)[1] // film.pitch, torch.ones_like(places[1]))
    again = film.backward.onward(film.onward(places))
    assert float((again - places).abs().max()) < 0.2


@pytest.mark.parametrize("clip", [living(), drifting()])
def test_left_says_how_often_texture_can_go_on(clip: Tensor) -> None:
    for film in (Film.of(Exemplar.of(clip)), Film.of(Exemplar.of(clip)).backward):
        places = pixel_coordinates(film.strip.shape)[:, 2 * film.pitch : 2 * film.pitch + 64 : 9, ::9].flatten(1)
        counted, here = torch.zeros(places.shape[1]), places
        for _ in range(film.pages):
            there = film.onward(here)
            counted += (there != here).any(0)
            here = there
        x, y = places.long()
        assert float((film.left[y, x] - counted).abs().max()) <= 1
        assert torch.equal(film.onward(here), here)


def test_age_grows_as_the_end_comes_near() -> None:
    film = Film.of(Exemplar.of(living()))
    aging = Aging(film, 0.6)
    ages = [float(aging.of(torch.tensor([[30.0], [20.0 + film.pitch * page]]))) for page in range(film.pages)]
    assert ages == pytest.approx([0.0] * 6 + [0.2, 0.4, 0.6])
    assert torch.equal(aging.costs(torch.arange(20, 21))[:, 30], torch.zeros(1))
    assert float(Aging(Film.of(Exemplar.of(cloud(20, 30))), 0.6).costs(torch.arange(20)).max()) == 0


def test_texture_lives_on_in_place_where_nothing_flows() -> None:
    clip = living()
    frames = animated(clip, 0.0 * flow.uniform(), 4, renewing=PLAIN)
    for before, after in pairwise(frames):
        grows = before.where[0] < 8
        assert torch.equal(after.where[0][grows], before.where[0][grows] + 1)
        assert torch.equal(after.where[1:], before.where[1:])
    last = frames[-1]
    pixels = clip[0][tuple(last.where)]
    assert float((last.image[0] - pixels).abs().median()) < 0.01


def test_what_drifts_is_shown_to_move_as_the_field_says_and_not_as_it_did() -> None:
    for field in (0.0 * flow.uniform(), flow.uniform(1.5, 90)):
        frames = animated(drifting(), field, 4)
        errors = [flow.end_point_error(flow.seen(a.image, b.image), field(0, SHAPE)) for a, b in pairwise(frames)]
        assert sum(errors) / len(errors) < 0.5


def test_pages_that_end_are_renewed_without_a_pulse() -> None:
    frames = animated(living(), flow.rotation(1.0), 24, seed=1)
    steps = torch.tensor([float((b.image - a.image).abs().mean()) for a, b in pairwise(frames)])[6:]
    assert float(steps.max()) < 3 * float(steps.median())
    ended = [float((frame.where[0] == 8).float().mean()) for frame in frames[8:]]
    assert max(ended) < 0.5
    assert sum(frame.energies[0]["renewed"] for frame in frames[8:]) > 0


def test_going_on_after_a_state_and_other_threads_give_the_same_bits() -> None:
    whole = animated(living(), flow.rotation(2.0), 6, seed=3)
    torch.set_num_threads(2)
    rest = animated(living(), flow.rotation(2.0), 6, seed=3, after=whole[2].state)
    for frame, again in zip(whole[3:], rest, strict=True):
        assert torch.equal(frame.image, again.image)
        assert torch.equal(frame.source, again.source)


def test_a_video_loops() -> None:
    frames = list(flow.loop(living(), flow.rotation(1.0), SHAPE, frames=10, renewing=QUICK))
    steps = [float((b.image - a.image).abs().mean()) for a, b in pairwise([*frames, frames[0]])]
    assert steps[-1] < 1.5 * max(steps[:-1])


def test_masked_texture_is_never_shown() -> None:
    mask = torch.ones(9, 64, 72, dtype=torch.bool)
    mask[:, 20:40, 30:50] = False
    frames = animated(torch.where(mask, living(), 0.0), flow.rotation(2.0), 3)
    exemplar = Exemplar.of(torch.where(mask, living(), 0.0), masks=[mask])
    for frame in flow.animate(exemplar, flow.rotation(2.0), SHAPE, frames=3, renewing=QUICK):
        assert bool(mask[tuple(frame.source[1:])].all())
    assert len(frames) == 3


def test_short_clips_and_small_frames_are_enough() -> None:
    for clip in (living()[:, :2], living()[:, :3], torch.rand(3, 4, 12, 14)):
        frames = list(flow.animate(clip, flow.rotation(1.0), (16, 18), frames=4))
        assert all(bool(frame.image.isfinite().all()) for frame in frames)
