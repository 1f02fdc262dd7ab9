"""Light that goes on evenly in space and in time."""

import numpy as np
import pytest
import torch

import synth
from kwatra import Exemplar
from synth.texture.light import AROUND, FADING, SHORT, evened, evened_inside
from synth.texture.steps import corrections


def clip(frames: int = 8, side: int = 32) -> torch.Tensor:
    """Blotches that stay, and grow brighter by .02 a frame."""
    coarse = torch.rand(1, 3, 1, 8, 8, generator=torch.Generator().manual_seed(0))
    still = torch.nn.functional.interpolate(coarse, (1, side, side), mode="trilinear")[0] / 2
    return still + 0.02 * torch.arange(float(frames)).view(-1, 1, 1)


def places(frames: list[int], side: int = 32) -> torch.Tensor:
    """The map of frames of the clip, one after the other."""
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    return torch.stack([torch.stack([torch.full_like(y, t), y, x]) for t in frames], 1)


def steps(video: torch.Tensor) -> torch.Tensor:
    """The mean step of light from each frame to the next."""
    return video.mean((0, 2, 3)).diff()


def test_a_step_of_light_where_pieces_meet_is_spread_and_details_are_not_touched():
    z = clip()
    order = [0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5]  # a step of -.1 where there should be one of .02
    x = z[:, order]
    even = evened(x, places(order), Exemplar.of(z), (False,) * 3)
    assert float(steps(x).min()) == pytest.approx(-0.1, abs=1e-4)
    assert float(steps(even).min()) > -0.06
    light = even - x
    assert torch.allclose(light, light.mean((2, 3), keepdim=True).expand_as(light), atol=1e-5)
    assert float(light.mean()) == pytest.approx(0.0, abs=1e-5)  # no brighter or darker on the whole


def test_what_goes_on_as_in_the_exemplar_is_left_as_it_is():
    z = clip()
    order = [2, 3, 4, 5, 6]
    assert torch.allclose(evened(z[:, order], places(order), Exemplar.of(z), (False,) * 3), z[:, order], atol=1e-6)


@pytest.mark.parametrize("axis", [2, 3])
def test_a_step_of_light_where_pieces_meet_in_a_frame_is_spread(axis):
    grows = 0.004 * torch.arange(48.0).view([-1] + [1] * (3 - axis))
    z = grows + 0.1 * torch.rand(3, 3, 48, 48, generator=torch.Generator().manual_seed(1))
    where = places([0, 1, 2], 48)
    where[axis - 1] = where[axis - 1] % 24 + 12  # from 12 to 35, and again: a step of -.1
    x = z[(slice(None), *where)]
    even = evened(x, where, Exemplar.of(z), (False,) * 3)
    before, after = (v.mean([a for a in range(4) if a != axis]) for v in (x, even))
    assert float(before.diff()[23]) == pytest.approx(-0.1, abs=0.02)
    assert float(after.diff()[23]) == pytest.approx(0.004, abs=0.02)
    assert float((after - before).diff()[torch.arange(47) != 23].abs().max()) < 0.02
    assert abs(float((even - x).mean())) < 0.005  # no brighter or darker on the whole


def test_a_piece_that_ends_where_its_clip_does_and_is_continued_exactly_is_left_as_it_is():
    once = torch.rand(3, 2, 24, 24, generator=torch.Generator().manual_seed(1))
    where = places([0, 1], 72)[:, :, :24]
    where[2] -= 24 * (where[2] >= 48)  # the last column of a clip that shows all twice, then its middle
    x = once.repeat(1, 1, 1, 3)
    assert torch.allclose(evened(x, where, Exemplar.of(once.repeat(1, 1, 1, 2)), (False,) * 3), x, atol=1e-5)


@pytest.mark.parametrize("wrap", [(False,) * 3, (True,) * 3, (False, False, True), (True, False, True)])
def test_corrections_in_space_solve_their_equations(wrap):
    pull = torch.randn(5, 40, 30, generator=torch.Generator().manual_seed(1)).numpy()
    light = corrections(pull, wrap, FADING)
    assert light.dtype == np.float32
    left = FADING * light
    for axis, around in enumerate(wrap):
        sides = [(1, 1) if axis == each else (0, 0) for each in range(3)]
        near = np.pad(light, sides, "wrap" if around else "edge")
        left = left - np.diff(near, 2, axis)
    assert np.allclose(left, pull, atol=1e-4)


def test_where_frames_have_nothing_to_do_with_each_other_light_stays():
    z = torch.rand(3, 40, 1, 1, generator=torch.Generator().manual_seed(2)).expand(-1, -1, 16, 16)
    order = [0, 1, 2, 20, 21, 22]
    light = evened(z[:, order], places(order, 16), Exemplar.of(z), (False,) * 3) - z[:, order]
    lack = float(z[:, order].diff(dim=1).abs().mean())
    assert float(light.abs().mean()) < 0.01 * lack
    still = torch.rand(3, 1, 16, 16, generator=torch.Generator().manual_seed(3)).expand(-1, 40, -1, -1)
    assert torch.equal(evened(still[:, [5, 7]], places([5, 7], 16), Exemplar.of(still), (False,) * 3), still[:, [5, 7]])


def test_it_is_the_least_of_its_sum():
    """Against the normal equations written out for a video whose light is the same all over a frame."""
    z = clip()
    order = [4, 5, 1, 2, 7]
    even = evened(z[:, order], places(order), Exemplar.of(z), (False,) * 3)
    lasting = 1 - 1 / (2 * torch.arange(8.0).var())  # steps of 1 among 8 frames in a row, in units of their variance
    found = (even - z[:, order]).mean((0, 2, 3)).double() / lasting
    wanted = torch.full((4,), 0.02, dtype=torch.double) - steps(z[:, order]).double()
    step = torch.eye(5, dtype=torch.double).diff(dim=0)
    solved = torch.linalg.solve(step.T @ step + SHORT * torch.eye(5, dtype=torch.double), step.T @ wanted)
    assert torch.allclose(found, solved, atol=1e-5)


def test_in_a_loop_the_last_frame_leads_to_the_first():
    z = clip()
    order = list(range(8))
    loop = evened(z, places(order), Exemplar.of(z), (True, False, False))
    assert float((loop[:, -1] - loop[:, 0]).mean()) < 0.5 * float((z[:, -1] - z[:, 0]).mean())


def test_held_frames_keep_every_bit_and_others_lead_up_to_them():
    z = clip()
    order = [6, 7, 0, 1, 2, 3]
    held = torch.tensor([True, True, False, False, False, False])
    even = evened(z[:, order], places(order), Exemplar.of(z), (False,) * 3, held)
    assert torch.equal(even[:, :2], z[:, order][:, :2])
    assert float(steps(even)[1]) > 0.5 * float(steps(z[:, order])[1])


def test_only_light_counts_and_clips_do_not_continue_each_other():
    z = clip()
    fine = z + 0.05 * torch.randn(z.shape, generator=torch.Generator().manual_seed(1))
    both = Exemplar.of([fine, 1 - fine])
    there = int((both.owner == 1).nonzero()[0, 0]), int((both.owner == 1).nonzero()[0, 1])
    order = [0, 1, 2, 3]
    where = places(order)
    where[0, 2:] = where[0, 2:] + there[0]
    where[1, 2:] = where[1, 2:] + there[1]
    where[2, 2:] = where[2, 2:] + int((both.owner == 1).nonzero()[0, 2])
    x = torch.stack([fine[:, 0], fine[:, 1], 1 - fine[:, 2], 1 - fine[:, 3]], 1)
    light = evened(x, where, both, (False,) * 3) - x
    rough = light - torch.nn.functional.avg_pool2d(light, 2 * int(AROUND) + 1, 1, int(AROUND), count_include_pad=False)
    assert float(rough.square().mean()) < 0.1 * float(light.square().mean())


def test_details_that_last_pass_over_into_each_other_where_pieces_meet_in_time():
    where = places([2, 3, 4, 2, 3, 4])
    where[2, 3:] = (where[2, 3:] + 4).clamp(max=31)  # light stripes come where dark ones were
    stripes = torch.sin(2 * torch.pi * torch.arange(32.0) / 8)

    def left(strength: torch.Tensor) -> float:
        """How much of the change at the joint is left where frames show stripes of some strengths (8,)."""
        z = clip() + strength.view(-1, 1, 1) * stripes
        x = z[(slice(None), *where)]
        before, after = (
            v[..., 4:24].diff(dim=1)[:, 2].abs().mean() for v in (x, evened(x, where, Exemplar.of(z), (False,) * 3))
        )
        return float(after / before)

    assert left(0.1 + 0.01 * torch.arange(8.0)) < 0.75
    assert left(torch.tensor([0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2])) > 0.85


def test_what_is_asked_of_pixels_is_not_made_brighter():
    z = clip(6, 24)
    start = z.flip(1)
    steered = synth.synthesize(z, (6, 24, 24), start=start, preset="fast")
    assert torch.equal(steered.image, steered.form.restored(steered.result.image))


def test_what_is_known_stays_and_copies_of_another_brightness_go_on_from_it():
    z = torch.cat([clip(6), clip(6) + 0.2], 3)  # (3, 6, 32, 64): on the right all is brighter
    where = places(list(range(6)))
    free = torch.zeros(6, 32, 32, dtype=torch.bool)
    free[:, 10:20, 8:22] = True
    where[2] += 32 * free
    x = z[(slice(None), *where)]
    even = evened_inside(x, where, Exemplar.of(z), free)
    assert torch.equal(even[:, ~free], x[:, ~free])
    assert float((x - clip(6))[:, free].mean()) == pytest.approx(0.2, abs=1e-5)
    assert float((even - clip(6))[:, free].abs().max()) < 0.01
    assert torch.allclose(evened_inside(clip(6), places(list(range(6))), Exemplar.of(z), free), clip(6), atol=1e-5)


def test_one_frame_is_evened_inside_as_any():
    z = torch.cat([clip(1), clip(1) + 0.2], 3)
    where, free = places([0]), torch.zeros(1, 32, 32, dtype=torch.bool)
    free[:, 10:20, 8:22] = True
    where[2] += 32 * free
    even = evened_inside(z[(slice(None), *where)], where, Exemplar.of(z), free)
    assert float((even - clip(1)).abs().max()) < 0.01
