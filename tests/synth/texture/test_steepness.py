"""Details that are as strong as those of what a video is copied from."""

import pytest
import torch

import synth
from kwatra import Exemplar
from kwatra.source import look_up
from synth.texture import work
from synth.texture.steepness import MOST, _inside, steepened

NOWHERE = (False,) * 3


def clip(frames=6, side=48, seed=0):
    """Noise, whose frames have nothing in common."""
    return torch.rand(3, frames, side, side, generator=torch.Generator().manual_seed(seed))


def places(frames, side=48):
    """The map of frames of a clip, one after the other."""
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    return torch.stack([torch.stack([torch.full_like(y, t), y, x]) for t in frames], 1)


def steep(video):
    """Frame by frame the rms step, away from the border."""
    inner = video[:, :, 8:-8, 8:-8]
    return (inner.diff(dim=2).square().mean((0, 2, 3)) + inner.diff(dim=3).square().mean((0, 2, 3))).sqrt()


def test_what_is_copied_is_left_as_it_is_where_pieces_meet_too():
    z = clip()
    where = places([1, 2, 3, 4])
    where[:, :, :, 24:] = where[:, :, :, 24:].roll(1, 1)
    x = look_up(z, where)
    made = steepened(x, where, Exemplar.of(z), NOWHERE)
    for apart in (slice(0, 11), slice(37, 48)):  # by four deviations
        assert torch.allclose(made[..., apart], x[..., apart], atol=1e-4)
    whole = places([1, 2, 3, 4])
    assert torch.allclose(steepened(look_up(z, whole), whole, Exemplar.of(z), NOWHERE), look_up(z, whole), atol=1e-4)


@pytest.mark.parametrize("part", [0.5, 0.25])
def test_details_of_means_are_as_strong_as_those_of_one(part):
    z = clip()
    mean = (1 - part) * z[:, [0, 1, 2]] + part * z[:, [3, 4, 5]]
    made = steepened(mean, places([0, 1, 2]), Exemplar.of(z), NOWHERE)
    before, after, wanted = (steep(one) for one in (mean, made, z[:, [0, 1, 2]]))
    assert float((before / wanted).max()) < 0.81
    assert torch.allclose(after, wanted, rtol=0.03)
    light = [one[:, :, 8:-8, 8:-8].mean((2, 3)) for one in (mean, made)]
    assert torch.allclose(*light, atol=2e-3)  # no brighter or darker


def test_nothing_is_enlarged_without_bounds_or_made_weaker_or_touched_in_frames_that_are_held():
    z = clip()
    x = torch.stack([0.5 + 0.1 * (z[:, 0] - 0.5), z[:, 1], 0.5 + 0.5 * (z[:, 2] - 0.5)], 1)
    flat = Exemplar.of(0.5 + 0.5 * (z - 0.5))
    held = torch.tensor([False, False, True])
    made = steepened(x, places([0, 1, 2]), flat, NOWHERE, held)
    assert float(steep(made)[0] / steep(x)[0]) == pytest.approx(MOST, rel=0.05)
    assert torch.equal(made[:, 1:], x[:, 1:])


def test_rows_and_columns_that_are_periodic_go_on_at_the_other_side():
    z, where = clip(), places([0, 1])
    x = (z[:, [0, 1]] + z[:, [2, 3]]) / 2
    around = (False, True, True)
    made = steepened(x, where, Exemplar.of(z), around)
    moved = steepened(x.roll(20, 3), where.roll(20, 3), Exemplar.of(z), around).roll(-20, 3)
    assert torch.allclose(made[..., 2:-2], moved[..., 2:-2], atol=0.03)


def test_steps_from_a_clip_to_the_next_on_the_canvas_are_none():
    dark, light = clip(4, 24) * 0.1, 0.9 + clip(4, 24, seed=1) * 0.1
    exemplar = Exemplar.of([dark, light])
    last = int((exemplar.owner[0, :, 0] == 0).nonzero().max())
    where = places([0, 1], 24)
    assert last == 23  # the first clip's last row borders on a gap of zeros, and what is there on none
    x = look_up(exemplar.canvas, where)
    assert torch.allclose(steepened(x, where, exemplar, NOWHERE), x, atol=1e-4)


def test_a_video_is_shown_with_strong_details(monkeypatch):
    z = torch.nn.functional.avg_pool3d(clip(8, 34), 3, 1)
    made = synth.synthesize(z, (12, 32, 32), seed=0).image
    monkeypatch.setattr(work, "steepened", lambda video, *_: video)
    soft = synth.synthesize(z, (12, 32, 32), seed=0).image
    assert float(steep(made).mean()) > 1.01 * float(steep(soft).mean())


def test_steps_inside_are_those_between_pixels_of_one_owner():
    owner = torch.zeros(1, 5, 7)
    owner[:, 2:, 3:] = 1
    inside = _inside(owner)
    rows, columns = torch.ones(5, 7), torch.ones(5, 7)
    rows[4], rows[1, 3:], columns[:, 6], columns[2:, 2] = 0, 0, 0, 0
    assert torch.equal(inside[:, 0], torch.stack([rows, columns]))
