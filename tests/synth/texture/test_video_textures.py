"""Video textures by the engine."""

import numpy as np
import pytest
import torch

import synth
from kwatra import InputError
from synth.texture import stretch as plan
from synth.texture.images import stretches
from synth.texture.stretch import planned_stretches


@pytest.fixture(scope="module")
def clip() -> np.ndarray:
    """Blobs on a torus that rise by two pixels a frame and go right by one, (12, 24, 24, 3) uint8."""
    field = torch.rand(3, 24, 24, generator=torch.Generator().manual_seed(1))
    smooth = torch.nn.functional.avg_pool2d(field.repeat(1, 3, 3), 5, 1, 2)[:, 24:48, 24:48]
    frames = torch.stack([smooth.roll((-2 * t, t), (1, 2)) for t in range(12)])
    low, high = frames.min(), frames.max()
    return ((frames - low) / (high - low) * 255).round().byte().permute(0, 2, 3, 1).numpy()


def test_a_video_is_of_its_exemplars_kind_and_says_where_in_time_it_comes_from(clip):
    made = synth.synthesize(clip, (15, 20, 28))
    assert made.image.shape == (15, 20, 28, 3)
    assert made.image.dtype == np.uint8
    assert made.source.shape == (4, 15, 20, 28)
    taken = made.take(clip)
    assert np.abs(taken.astype(float) - made.image).mean() < 12  # blended of what it says it comes from
    tensor = synth.synthesize(torch.from_numpy(clip).movedim(-1, 0).float() / 255, (15, 20, 28))
    assert tensor.image.shape == (3, 15, 20, 28)
    assert tensor.image.dtype == torch.float32


def test_a_clip_that_only_translates_is_extended_exactly(clip):
    whole = np.stack([np.roll(clip[0], (-2 * t, t), (0, 1)) for t in range(32)])
    for frames, length in ((24, 36), (16, 32)):  # as far as the blobs' way around, and two thirds of it
        made = synth.synthesize(whole[:frames], (length, 24, 24), stay=0.0, seed=frames).image
        assert np.array_equal(made[1:, :-2, 1:], made[:-1, 2:, :-1])


def test_a_clip_that_moves_halfway_around_goes_on_nearly_exactly(clip):
    made = synth.synthesize(clip, (24, 24, 24), stay=0.0, seed=1).image.astype(float)
    change = np.abs(np.diff(made, axis=0)).mean()
    there = np.abs(np.diff(clip.astype(float), axis=0)).mean()
    assert change == pytest.approx(there, rel=0.02)
    apart = np.abs(made[1:, :-2, 1:] - made[:-1, 2:, :-1])
    assert (apart < 3).mean() > 0.99


def test_a_checkerboard_in_space_and_time_goes_on_exactly():
    t, y, x = np.indices((16, 16, 16))
    board = (((t // 2 + y // 4 + x // 4) % 2) * 255).astype(np.uint8)[..., None]
    made = synth.synthesize(board, (12, 24, 24)).image
    later, rows, columns = made[4:], made[:, 8:], made[:, :, 8:]
    for ours, shifted in ((made[:-4], later), (made[:, :-8], rows), (made[:, :, :-8], columns)):
        assert np.array_equal(ours, shifted)
    assert np.array_equal(made[2:], 255 - made[:-2])


def test_every_window_of_a_loop_exists_in_the_exemplar(clip):
    whole = np.stack([np.roll(clip[0], (-2 * t, t), (0, 1)) for t in range(24)])  # all that it ever shows
    made = synth.synthesize(whole, (24, 24, 24), loop=True, stay=0.0).image
    assert around(made) <= around(whole)
    assert not np.array_equal(made, whole)


def test_what_does_not_come_round_by_itself_does_in_a_loop():
    phases = np.concatenate([np.arange(count) for count in (6, 5, 6, 6, 5, 5, 6)])
    y, x = np.indices((16, 16)) // 4
    pulse = (30 * phases[:, None, None, None] + 60 * ((y + x) % 2)[None, :, :, None]).astype(np.uint8)
    for loop in (False, True):
        made = synth.synthesize(pulse, (16, 16, 16), loop=loop, stay=0.0).image  # rounds of 5, 5 and 6
        assert (around(made) <= {window.tobytes() for window in windows(pulse)}) == loop


def around(video: np.ndarray) -> set[bytes]:
    """All windows of a video that is played round and round."""
    return {window.tobytes() for window in windows(np.concatenate([video, video[:3]]))}


def windows(video: np.ndarray) -> np.ndarray:
    """All windows of 4 frames of 8x8 pixels."""
    return np.lib.stride_tricks.sliding_window_view(video, (4, 8, 8), (0, 1, 2)).reshape(
        -1, video.shape[-1] * 4 * 8 * 8
    )


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_clips_of_a_few_frames_will_do(clip, frames):
    made = synth.synthesize(clip[:frames], (5, 24, 24), preset="fast")
    assert made.image.shape == (5, 24, 24, 3)
    assert made.source[1].max() < frames


def test_one_stretch_after_the_other_is_the_whole_video(clip, monkeypatch):
    monkeypatch.setattr(plan, "VOXELS", 1)  # stretches as short as they may be
    whole = synth.synthesize(clip, (36, 24, 24), preset="fast", seed=3)
    parts = list(stretches(clip, (36, 24, 24), preset="fast", seed=3))
    assert len(parts) > 1
    assert np.array_equal(np.concatenate([part.image for part in parts]), whole.image)
    assert whole.source.shape == (4, 36, 24, 24)
    assert whole.source[0].min() == 0
    first = len(parts[0].image)
    rest = stretches(clip, (36, 24, 24), preset="fast", seed=3, done=first + 2, shown=lambda a, b: whole.image[a:b])
    assert np.array_equal(np.concatenate([part.image for part in rest]), whole.image[first + 2 :])


def test_stretches_join_without_a_jerk(clip, monkeypatch):
    monkeypatch.setattr(plan, "VOXELS", 1)
    frames = 48  # the blobs are back after 24: only so can they loop without a jerk
    for loop in (False, True):
        made = synth.synthesize(clip, (frames, 24, 24), loop=loop, stay=0.0, seed=1).image.astype(float)
        cuts = {part.first for part in planned_stretches((frames, 24, 24), loop)} - {0}
        steps = np.abs(np.diff(made, axis=0, append=made[:1])).mean((1, 2, 3))
        usual = np.delete(steps, [*(cut - 1 for cut in cuts), frames - 1])
        joins = [steps[cut - 1] for cut in cuts] + [steps[frames - 1]] * loop
        assert max(joins) <= 1.02 * usual.max()


def test_stretches_cover_the_video_and_hold_what_was_before():
    assert len(planned_stretches((60, 100, 100), False)) == 1
    parts = planned_stretches((10_000, 144, 192), True)
    assert [part.first for part in parts[1:]] == [part.stop for part in parts[:-1]]
    assert parts[0].first == 0
    assert parts[-1].stop == 10_000
    assert {part.before for part in parts[1:]} == {plan.HELD}
    assert parts[0].before == 0
    assert parts[-1].after == plan.HELD
    assert {part.after for part in parts[:-1]} == {0}
    assert max(part.length for part in parts) * 144 * 192 <= plan.VOXELS + 2 * plan.HELD * 144 * 192


def test_the_number_of_threads_changes_no_bit(clip):
    made = []
    for threads in (1, 2):
        torch.set_num_threads(threads)
        made.append(synth.synthesize(clip, (10, 24, 30), seed=2**40).image)
    assert np.array_equal(*made)


def test_a_guide_says_what_belongs_where_in_time(clip):
    two = np.concatenate([clip, 255 - clip], 1)
    labels = np.zeros((12, 48, 24, 1), np.uint8)
    labels[:, 24:] = 1
    wanted = np.zeros((8, 24, 24, 1), np.uint8)
    wanted[4:] = 1
    made = synth.synthesize(two, guide=(labels, wanted))
    assert (made.source[2][:4] < 24).mean() > 0.8
    assert (made.source[2][5:] >= 24).mean() > 0.8


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"size": (24, 24)}, "number of frames, height and width"),
        ({"stay": -1.0}, "weight of staying"),
        ({"stay": 1.0, "tile": True}, "leave out stay, or tile"),
    ],
)
def test_what_makes_no_sense_is_refused(clip, options, said):
    with pytest.raises(InputError, match=said):
        synth.synthesize(clip, **{"size": (6, 24, 24), **options})


def test_images_do_not_loop():
    with pytest.raises(InputError, match="a loop is for videos"):
        synth.synthesize(np.zeros((8, 8), np.uint8), (8, 8), loop=True)
    with pytest.raises(InputError, match="stretches are of videos"):
        stretches(np.zeros((8, 8), np.uint8), (8, 8))


def test_a_hole_in_a_video_is_filled_in_space_and_time(clip):
    still = np.zeros((24, 24), bool)
    still[8:14, 9:15] = True
    once = np.zeros((12, 24, 24), bool)
    once[4:7, 5:18, 5:18] = True
    for hole in (still, once):
        where = np.broadcast_to(hole, clip.shape[:3])
        broken = np.where(where[..., None], np.uint8(255), clip)
        filled = synth.fill(broken, hole, preset="fast")
        assert np.array_equal(filled.image[~where], clip[~where])
        assert filled.source.shape == (4, 12, 24, 24)
        error = np.abs(filled.image.astype(float) - clip)[where].mean()
        other = np.abs(clip[6:].astype(float) - clip[:6]).mean()  # of frames that have nothing to do with each other
        assert error < 0.5 * other


def test_a_hole_of_another_length_is_refused(clip):
    with pytest.raises(InputError, match="the hole is"):
        synth.fill(clip, np.ones((5, 24, 24), bool))
