"""Holes in videos: what moves goes on, nothing is blurred, light has no step, and what is known stays."""

import numpy as np
import pytest
import torch

from synth import fill
from synth.texture import holes
from synth.texture.work import PRESETS


def passing(frames: int = 12, side: int = 40, seed: int = 0) -> np.ndarray:
    """Fine detail (T, side, side, 3), 0 to 1, that moves right by 2 px a frame."""
    random = torch.Generator().manual_seed(seed)
    sky = torch.rand(1, 3, side + 2, side + 2 * frames + 2, generator=random)
    sky = torch.nn.functional.avg_pool2d(sky, 3, 1)[0]
    moving = [sky[:, :, 2 * (frames - t) : 2 * (frames - t) + side] for t in range(frames)]
    return torch.stack(moving).permute(0, 2, 3, 1).contiguous().numpy()


def restless(frames: int = 12, side: int = 40) -> np.ndarray:
    """Grain (T, side, side, 1) that is new in every frame, under light that falls from the left."""
    grain = np.random.default_rng(0).normal(0, 0.05, (frames, side, side))
    return (0.3 + 0.4 * np.linspace(1, 0, side) + grain).astype(np.float32)[..., None]


def middle(video: np.ndarray, half: int = 6) -> np.ndarray:
    """A hole in the middle of all frames."""
    hole = np.zeros(video.shape[:3], bool)
    at = tuple(slice(side // 2 - half, side // 2 + half) for side in video.shape[1:3])
    hole[(slice(None), *at)] = True
    return hole


def gradient(video: np.ndarray, where: np.ndarray) -> float:
    """The mean absolute step along rows and columns, of pixels somewhere."""
    down, across = (np.abs(np.diff(video, axis=axis)) for axis in (1, 2))
    return float(down[where[:, 1:]].mean() + across[where[:, :, 1:]].mean())


def test_what_passes_behind_a_hole_goes_on_there() -> None:
    truth = passing()
    hole = middle(truth, 9)
    made = fill(np.where(hole[..., None], np.float32(9), truth), hole)
    assert np.array_equal(made.image[~hole], truth[~hole])
    later, down, across = np.argwhere(hole).T - made.source[1:, hole]
    along = (down == 0) & (across == 2 * later)
    off = np.abs(made.image - truth)[hole]
    assert along.mean() > 0.75  # .6 where blocks only prefer what is like it
    assert off[along].mean() < 0.01
    assert off.mean() < 0.4 * np.abs(truth[hole] - truth.mean()).mean()
    assert not hole[tuple(made.source[1:, hole])].any()
    place = np.indices(hole.shape)
    assert np.array_equal(made.source[1:, ~hole], place[:, ~hole])


def test_grain_is_as_strong_as_around_and_light_goes_on() -> None:
    truth = restless()
    hole = middle(truth)
    made = fill(np.where(hole[..., None], np.float32(0), truth), hole).image
    assert gradient(made, hole) > 0.75 * gradient(truth, hole)
    over_time = made.mean(0)  # what is left of the grain is small
    assert np.abs(over_time - truth.mean(0))[hole[0]].mean() < 0.03
    beside = np.abs(np.diff(made[:, 15:25], axis=2).mean((0, 1, 3)))
    assert beside.max() < 0.05


def test_frames_that_are_missing_come_from_others() -> None:
    truth = passing()
    hole = np.zeros(truth.shape[:3], bool)
    hole[5:7] = True
    made = fill(truth, hole, seed=2).image
    assert np.array_equal(made[~hole], truth[~hole])
    assert gradient(made, hole) > 0.8 * gradient(truth, hole)


@pytest.mark.parametrize("frames", [1, 2])
def test_short_videos_are_filled(frames: int) -> None:
    truth = restless(frames)
    hole = middle(truth)
    made = fill(truth, hole).image
    assert np.array_equal(made[~hole], truth[~hole])
    assert gradient(made, hole) > 0.7 * gradient(truth, hole)


def test_other_videos_of_any_size_may_be_the_exemplars() -> None:
    truth, others = passing(), [passing(8, 32, 1), passing(10, 28, 2)]
    hole = middle(truth)
    made = fill(truth, hole, exemplar=others)
    number, *place = made.source[:, hole]
    assert set(number) <= {0, 1}
    assert (made.source[0, ~hole] == -1).all()
    for own, other in enumerate(others):
        mine = number == own
        there = other[tuple(axis[mine] for axis in place)]
        assert np.abs(made.image[hole][mine] - there).mean() < 0.15
    assert gradient(made.image, hole) > 0.8 * gradient(truth, hole)


def test_the_best_of_several_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "best", (PRESETS["fast"][0], 2))
    truth = passing(6)
    hole = middle(truth)
    one, best = fill(truth, hole, preset="fast"), fill(truth, hole, preset="best")
    assert best.image.shape == one.image.shape
    assert np.array_equal(best.image[~hole], truth[~hole])


def test_seams_are_feathered_where_frames_tell_little_of_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = restless(6)
    hole, widths = middle(truth), list[float]()
    crisp = fill(truth, hole).image

    def feathered(video: torch.Tensor, where: object, exemplar: object, width: float, *rest: object) -> torch.Tensor:
        widths.append(width)
        return torch.full_like(video, 0.5)

    monkeypatch.setattr("synth.texture.closing.passage", lambda exemplar: 3.0)
    monkeypatch.setattr("synth.texture.closing.feathered", feathered)
    made = fill(truth, hole).image
    assert widths == [3.0]
    assert np.array_equal(made[~hole], truth[~hole])
    assert gradient(made, hole) < 0.95 * gradient(crisp, hole)  # light goes on by what copies change by all the same


def test_the_same_seed_gives_the_same_bits_for_any_number_of_threads() -> None:
    truth, threads = passing(6), torch.get_num_threads()
    hole = middle(truth)
    made = []
    try:
        for count in (1, 2):
            torch.set_num_threads(count)
            made.append(fill(truth, hole, seed=3).image)
    finally:
        torch.set_num_threads(threads)
    assert np.array_equal(*made)
    assert not np.array_equal(made[0], fill(truth, hole, seed=4).image)


def test_a_still_is_filled_in_one_part_and_a_long_video_in_several() -> None:
    still = torch.zeros(600, 700, dtype=torch.bool)
    still[300:310, 300:320] = True
    ((near, now),) = holes.parts_to_fill(still)
    assert near == (slice(40, 566), slice(40, 576))
    assert torch.equal(now, still[near])
    long = torch.zeros(100, 90, 80, dtype=torch.bool)
    long[10:95, 30:50, 20:45] = True
    long[40:70] = False
    done = torch.zeros_like(long)
    for near, now in holes.parts_to_fill(long):
        first, stop = now.flatten(1).any(1).nonzero()[[0, -1], 0].tolist()
        assert stop - first < holes.LONGEST
        known = done[near] | ~long[near]
        assert bool((known | now).all())  # nothing else is missing there
        assert not bool((done[near] & now).any())
        done[near] |= now
    assert torch.equal(done, long)


def test_a_part_sees_about_as_many_pixels_however_large_the_video() -> None:
    hole = torch.zeros(60, 300, 400, dtype=torch.bool)
    hole[:, 100:130, 100:150] = True
    seen = [now.numel() for _, now in holes.parts_to_fill(hole)]
    assert max(seen) < 1.3 * holes.VOXELS
    hole[:, 20:280, 20:380] = True
    done, most = torch.zeros_like(hole), 0
    for near, now in holes.parts_to_fill(hole):
        assert bool((now == (hole[near] & ~done[near])).all())
        done[near] |= now
        most = max(most, now.numel())
    assert torch.equal(done, hole)
    assert most < 1.3 * holes.VOXELS


def test_what_was_filled_before_is_gone_on_from_and_all_comes_from_what_is_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    truth = passing(20, 32)
    hole, told = middle(truth, 5), list[float]()
    monkeypatch.setattr(holes, "LONGEST", 7)
    made = fill(truth, hole, callback=lambda progress: told.append(progress.fraction))
    assert told == pytest.approx([1 / 3, 2 / 3, 1])
    assert np.array_equal(made.image[~hole], truth[~hole])
    assert not hole[tuple(made.source[1:, hole])].any()
    within = np.abs(np.diff(made.image, axis=0))[:, hole[0]].mean((1, 2))
    assert max(within[6], within[13]) < 1.3 * np.median(within)
    gap = np.zeros_like(hole)
    gap[4:16] = True  # 12 frames of 20, so that parts copy what was filled before
    made = fill(truth, gap)
    assert not gap[tuple(made.source[1:, gap])].any()
    assert gradient(made.image, gap) > 0.8 * gradient(truth, gap)
