"""Textures that flow: motion as asked, the same bits whatever the way there, and no wear however long."""

from dataclasses import replace
from itertools import islice, pairwise
from typing import Any

import faiss
import pytest
import torch
from skimage import data
from torch import Tensor
from wall import LONG, QUICK, SHAPE, animated, brick

import flow
from flow.animation.film.film import Film
from flow.animation.sequence import Motion
from flow.animation.settings import Renewing
from flow.animation.term import lasting
from kwatra import Exemplar, InputError, Settings
from kwatra.scoring.quality import forward_energy, sharpness


def test_without_motion_every_frame_is_the_first() -> None:
    frames = animated(0.0 * flow.uniform())
    for frame in frames[1:]:
        assert torch.equal(frame.image, frames[0].image)
        assert torch.equal(frame.state.source, frames[0].state.source)


@pytest.mark.usefixtures("nothing_hides_seams")  # which would move
def test_whole_pixel_shifts_are_exact_away_from_the_inflow() -> None:
    frames = animated(flow.uniform(2.0), renewing=Renewing(stiffness=0, blocks=0, block=24, window=12))
    for before, after in pairwise(frames):
        assert torch.equal(after.image[..., 32:-2], before.image[..., 30:-4])
        assert not torch.equal(after.image[..., 1:], before.image[..., :-1])


@pytest.mark.parametrize("name", ["rotation", "uniform:30", "source"])
def test_the_motion_that_is_seen_is_the_fields(name: str) -> None:
    field = flow.named(name, speed=2.0)
    frames = animated(field, 5, exemplar=torch.from_numpy(data.gravel()[:80, :80] / 255).float()[None])
    errors = [flow.end_point_error(flow.seen(a.image, b.image), field(0, SHAPE)) for a, b in pairwise(frames)]
    assert sum(errors) / len(errors) < 0.35


def test_a_sequence_has_no_end_unless_one_is_asked_for() -> None:
    endless = flow.animate(brick(), flow.rotation(1.0), SHAPE, renewing=QUICK)
    few = [frame.state.number for frame in islice(endless, 5)]
    assert few == [0, 1, 2, 3, 4]
    assert len(animated(flow.rotation(1.0), 5)) == 5
    assert len(animated(flow.rotation(1.0), 1)) == 1


def test_going_on_after_a_state_gives_the_same_bits() -> None:
    field = flow.noise(1.5, period=9)  # changes in time
    whole = animated(field, 6, seed=3)
    rest = animated(field, 6, seed=3, after=whole[2].state)
    assert [frame.state.number for frame in rest] == [3, 4, 5]
    for frame, again in zip(whole[3:], rest, strict=True):
        assert torch.equal(frame.image, again.image)
        assert torch.equal(frame.state.source, again.state.source)
        assert torch.equal(frame.source, again.source)
    assert animated(field, 3, seed=3, after=whole[2].state) == []
    other = animated(field, 6, seed=4)
    assert not torch.equal(other[5].image, whole[5].image)


def test_any_number_of_threads_gives_the_same_bits_and_global_randomness_is_left_alone() -> None:
    randomness, runs = torch.random.get_rng_state(), []
    for number in (1, 2):
        torch.set_num_threads(number)
        faiss.omp_set_num_threads(number)
        runs.append(animated(flow.rotation(3.0), 4))
    for one, two in zip(*runs, strict=True):
        assert torch.equal(one.image, two.image)
        assert torch.equal(one.state.source, two.state.source)
    assert runs[0][-1].energies[0]["renewed"] > 0
    assert torch.equal(torch.random.get_rng_state(), randomness)


def test_rotation_does_not_wear_out() -> None:
    """Sixty frames on, the picture is as sharp as the exemplar, and made of it."""
    shape, exemplar = (72, 72), brick(64)
    first = last = warped = None
    look = flow.lookup(flow.rotation(2.0)(0, shape))
    for last in flow.animate(exemplar, flow.rotation(2.0), shape, frames=61, renewing=LONG):
        first = last if first is None else first
        warped = last.image if warped is None else flow.filled(flow.warp(warped, look.coordinates), look.known)
    sharp = [sharpness(image, exemplar) for image in (first.image, last.image, warped)]
    assert sharp[1] == pytest.approx(1, rel=0.1)
    assert abs(sharp[2] / sharp[0] - 1) > 0.15
    assert forward_energy(last.image, exemplar) < 0.7 * forward_energy(warped, exemplar)


def test_the_map_says_where_every_pixel_comes_from() -> None:
    last = animated(flow.rotation(2.0), 4, exemplar=Exemplar.of([brick(), brick(64)]))[-1]
    assert last.source.shape == (3, *SHAPE)
    for number, image in enumerate((brick(), brick(64))):
        here = last.source[0] == number
        seen = image[0, last.source[1][here], last.source[2][here]]
        assert float((last.image[0][here] - seen).abs().median() if here.any() else 0) < 0.05
    assert set(last.source[0].unique().tolist()) <= {0, 1}


def test_reports_tell_wear_change_and_renewal() -> None:
    frames = animated(flow.rotation(2.0), 4)
    assert frames[0].energies == [{"frame": 0}]
    assert [frame.energies[0]["frame"] for frame in frames] == [0, 1, 2, 3]
    assert all(set(frame.energies[0]) == {"frame", "texture", "flow", "renewed"} for frame in frames[1:])


def test_a_given_first_frame_is_where_it_begins() -> None:
    given = brick(140)[:, 60:124, 60:132]
    first = animated(flow.uniform(1.0), 1, exemplar=brick(140), first=given)[0]
    assert float((first.image - given).abs().mean()) < 0.02
    assert bool((first.source[0] == 0).all())


def test_color_flows_as_gray_does() -> None:
    tinted = torch.cat([brick(), 0.5 * brick(), 1 - brick()])
    frames = animated(flow.uniform(1.3, angle=20), 3, exemplar=tinted)
    for frame in frames:
        assert frame.image.shape == (3, *SHAPE)
        assert torch.allclose(frame.image[0], 2 * frame.image[1], atol=0.02)


@pytest.mark.usefixtures("nothing_hides_seams")  # which would move
def test_a_field_that_changes_in_time_is_followed() -> None:
    right, down = flow.uniform(2.0)(0, SHAPE), flow.uniform(2.0, angle=90)(0, SHAPE)
    a, b, c = animated(
        flow.sampled(torch.stack([right, down])), 3, renewing=Renewing(stiffness=0, blocks=0, block=24, window=12)
    )
    assert torch.equal(b.image[..., 32:-2], a.image[..., 30:-4])
    assert torch.equal(c.image[:, 32:-2, 32:], b.image[:, 30:-4, 32:])


def test_a_frame_shows_its_copies_and_some_of_the_frame_before() -> None:
    field, inertia = flow.rotation(2.0), 1.5
    quick = replace(QUICK, inertia=inertia)
    motion = Motion(Film.of(Exemplar.of(brick())), field, SHAPE, None, None, quick, 0)
    renewal = motion.renewal
    look, kept = flow.lookup(field(0, SHAPE)), 0
    for before, after in pairwise(animated(field, 9, renewing=quick)):
        seen = motion.seen(after.state.source, after.state.inside, after.state.torn)
        copies = renewal.read.picture(seen, after.state.inside)
        moved = flow.warp(before.image, look.coordinates, quick.interpolation)
        unlike = (moved - copies)[0].square() / renewal.wear.variance
        off = (after.image - copies - lasting(unlike, inertia) * (moved - copies))[0].abs()
        assert float((off[look.known] < 0.02).float().mean()) > 0.98  # colors stay in the exemplar's range
        assert torch.equal(after.image[:, ~look.known], copies[:, ~look.known])
        assert float((after.image - copies)[0].square().max() / renewal.wear.variance) < 0.12**2  # no ghosts
        kept += int((after.image - copies)[0].abs().gt(0.01).sum())
    assert kept > 100


def test_what_is_shown_has_no_influence_on_what_is_copied() -> None:
    """Or it would blur: copies are chosen and worn by themselves."""
    field = flow.rotation(3.0)
    runs = [animated(field, 4, renewing=replace(QUICK, inertia=inertia)) for inertia in (0.0, 1.5)]
    for plain, fading in zip(*runs, strict=True):
        assert torch.equal(plain.state.source, fading.state.source)
    assert not torch.equal(runs[0][-1].image, runs[1][-1].image)


def test_frames_flicker_less_than_their_copies() -> None:
    """A frame differs from the one before it, carried along, less than its copies do."""
    field = flow.rotation(3.0)
    look = flow.lookup(field(0, SHAPE))
    inner = (slice(None), slice(8, -8), slice(8, -8))
    changes = []
    for inertia in (0.0, 1.5):
        frames = animated(field, 8, renewing=replace(QUICK, inertia=inertia))
        changes.append(
            sum(
                float((b.image - flow.warp(a.image, look.coordinates, "lanczos"))[inner].abs().mean())
                for a, b in pairwise(frames)
            )
        )
    assert changes[1] < 0.8 * changes[0]


def test_what_a_hole_of_the_exemplar_holds_has_no_influence_and_is_never_shown() -> None:
    hole = torch.ones(80, 80, dtype=torch.bool)
    hole[24:40, 30:52] = False
    runs = [
        animated(flow.rotation(2.0), 4, exemplar=Exemplar.of(torch.where(hole, brick(), value), masks=[hole]))
        for value in (0.0, 1.0)
    ]
    for one, other in zip(*runs, strict=True):
        assert torch.equal(one.image, other.image)
        assert bool(hole[one.source[1], one.source[2]].all())


@pytest.mark.parametrize(("side", "shape"), [(24, (32, 40)), (23, (40, 32)), (24, (8, 9)), (9, (32, 40))])
def test_tiny_exemplars_and_frames_are_enough(side: int, shape: tuple[int, int]) -> None:
    frames = list(flow.animate(brick(side), flow.rotation(1.0), shape, frames=3.0))  # whole, of whatever type
    assert len(frames) == 3
    for frame in frames:
        assert frame.image.shape == (1, *shape)
        assert bool(frame.image.isfinite().all())
        assert bool((frame.source >= 0).all())


def test_what_cannot_be_done_is_refused_at_once() -> None:
    def refused(match: str, exemplar: Exemplar | Tensor | None = None, field: flow.Field | None = None, **how) -> None:
        with pytest.raises(InputError, match=match):
            flow.animate(brick() if exemplar is None else exemplar, field or flow.uniform(), SHAPE, **how)

    refused("the number of frames is 0; give a whole number, at least 1, or None for no end", frames=0)
    refused("the number of frames is 2.5; give a whole number", frames=2.5)
    refused("the number of frames is two; give a whole number", frames="two")
    refused("texture is to enter from 'above'; give one of left, right, top, bottom, all", enter="above")
    refused("but a first frame is given; leave out one of the two", enter="left", first=brick())
    refused("is to enter from the right, but the flow never comes from there; give another side", enter="right")
    refused("is to enter from any side, but the flow never comes", enter="all", field=flow.source())
    refused("a flow is 30x20 but the frame 72x64", field=flow.sampled(torch.zeros(2, 20, 30)))
    refused("beyond the 72x64 frame; give a lower speed", field=flow.uniform(80.0))
    refused("1 vectors that are NaN", field=flow.Field(lambda t, s: torch.zeros(2, *s).index_put(
        (torch.tensor([0]), torch.tensor([3]), torch.tensor([3])), torch.tensor(torch.nan))))  # fmt: skip
    refused(r"a mask has shape \(4, 4\)", mask=torch.ones(4, 4, dtype=torch.bool))
    refused("a mask covers every pixel", mask=torch.zeros(SHAPE, dtype=torch.bool))
    state = flow.State(0, torch.zeros(2, 10, 12), torch.ones(10, 12, dtype=torch.bool), torch.zeros(1, 10, 12))
    refused(r"frames of 10x12 \(HxW\), not 64x72; give that shape", after=state)
    state = flow.State(0, torch.zeros(2, *SHAPE), torch.ones(SHAPE, dtype=torch.bool), torch.zeros(3, *SHAPE))
    refused("has 3 channels, the exemplar 1; give that it was made of", after=state)
    speck = torch.zeros(80, 80, dtype=torch.bool)
    speck[::3, ::3] = True
    refused("no 2x2 block fits into the exemplar", exemplar=Exemplar.of(brick(), masks=[speck]), turn=False)
    refused("no 4x4 window fits between the exemplar's holes", exemplar=Exemplar.of(brick(), masks=[speck]), turn=True)
    clip = brick()[:, None].repeat(1, 3, 1, 1)
    refused("that of a video keeps its directions", exemplar=Exemplar.of(clip), turn=True)


def test_a_motion_shows_the_state_it_is_given() -> None:
    motion = Motion(Film.of(Exemplar.of(brick())), flow.rotation(1.0), SHAPE, None, None, QUICK, 0)
    frame = motion.step(motion.begin(None, Settings()).state)
    assert torch.equal(motion.resumed(frame.state).image, frame.image)


@pytest.mark.parametrize("make", [flow.animate, flow.loop])
def test_a_map_of_the_exemplar_goes_along_as_its_colors_do_and_decides_nothing(make: Any) -> None:
    image, field = brick(), flow.rotation(1.0)
    noise = torch.rand(2, *image.shape[1:], generator=torch.Generator().manual_seed(0))
    plain = list(make(image, field, SHAPE, frames=5, renewing=QUICK))
    along = list(make(image, field, SHAPE, frames=5, renewing=QUICK, also=torch.cat([noise, image])))
    for one, other in zip(plain, along, strict=True):
        assert torch.equal(one.image, other.image)
        assert torch.equal(one.state.source, other.state.source)
        torch.testing.assert_close(other.also[2:], one.image, rtol=0, atol=1e-5)
        assert one.also is None
    after = along[2].state
    again = next(iter(make(image, field, SHAPE, frames=5, renewing=QUICK, also=torch.cat([noise, image]), after=after)))
    assert torch.equal(again.also, along[3].also)
    with pytest.raises(InputError, match="a map has its image's size"):
        make(image, field, SHAPE, frames=2, also=noise[:, :-1])
    with pytest.raises(InputError, match="the state to go on from has"):
        make(image, field, SHAPE, frames=5, renewing=QUICK, after=after)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((brick().numpy(), flow.uniform(1.0), SHAPE), "the exemplar is a ndarray; give a tensor"),
        ((brick(), torch.ones(2, *SHAPE), SHAPE), "the flow is a Tensor; give a field"),
        ((brick(), lambda t, shape: torch.ones(2, *shape), SHAPE), "the flow is a function; give a field"),
        ((brick(), flow.uniform(1.0), 40), "the frames' shape is .40,.; give 2 whole numbers"),
    ],
)
@pytest.mark.parametrize("animate", [flow.animate, flow.loop])
def test_what_is_of_another_kind_than_asked_is_refused(animate: Any, arguments: tuple[Any, ...], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        animate(*arguments, frames=3)
