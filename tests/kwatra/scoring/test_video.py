"""Figures on videos whose right answer is known."""

import itertools
import math
import sys

import pytest
import torch
from textures import noise
from torch import Tensor

from kwatra.base.errors import InputError
from kwatra.scoring import measure, motion
from kwatra.scoring.motion import Variogram, count_of_bands
from kwatra.scoring.nearest import Nearest, Projection, Windows
from kwatra.scoring.replay import replay
from kwatra.scoring.video import FIGURES

PERFECT = dict.fromkeys(FIGURES, 0.0) | {"sharpness": 1, "change": 1, "flicker": 1}


def drifting(frames: int = 12, side: int = 24, seed: int = 0, speed: int = 1) -> Tensor:
    """Smooth noise (1, T, side, side) that moves right by `speed` px a frame, over faint noise that does not stay."""
    sky = noise(1, side, side + speed * frames, seed=seed)
    for _ in range(2):
        sky = (sky + sky.roll(1, 1) + sky.roll(1, 2) + sky.roll((1, 1), (1, 2))) / 4
    moving = [sky[:, :, speed * (frames - t) : speed * (frames - t) + side] for t in range(frames)]
    return torch.stack(moving, 1) + 0.02 * noise(1, frames, side, side, seed=seed + 1)


def matched(output: Tensor, exemplar: Tensor) -> float:
    """The replay of a video, by all its windows."""
    ours, theirs = (Windows.of([video], 7, 1, 4) for video in (output, exemplar))
    numbers = torch.arange(len(ours))
    _, found = Nearest(theirs).search(ours.rows(numbers))
    return replay(ours, numbers, theirs, found)


@pytest.mark.parametrize("frames", [1, 2, 3, 12])
def test_a_video_is_perfect_beside_itself(frames: int) -> None:
    clip = drifting(frames)
    figures = measure(clip, clip)
    assert tuple(figures) == FIGURES
    kept = {name: value for name, value in figures.items() if name not in ("loop", "replay")}
    assert kept == pytest.approx({name: PERFECT[name] for name in kept}, abs=1e-5)
    assert figures["replay"] == (frames > 1)


def test_every_spoiling_is_seen_by_the_figure_that_is_for_it() -> None:
    clip = drifting(24)
    exemplar, good = clip[:, :12], clip[:, 12:]
    right = measure(good, exemplar)
    assert abs(1 - right["change"]) < 0.1
    assert max(right["tempo"], right["order"], right["direction"]) < 0.2
    frozen = measure(good[:, 5:6].expand(-1, 12, -1, -1), exemplar)
    assert (frozen["change"], frozen["flicker"], frozen["loop"]) == (0, 0, 0)
    assert min(frozen["tempo"], frozen["order"]) > 0.5
    backwards = measure(good.flip(1), exemplar)
    assert backwards["direction"] == pytest.approx(2, abs=0.3)
    assert abs(1 - backwards["change"]) < 0.1
    pingpong = measure(torch.cat((good[:, :6], good[:, :6].flip(1)), 1), exemplar)
    assert pingpong["direction"] == pytest.approx(1, abs=0.3)
    shuffled = measure(good[:, torch.tensor([5, 0, 8, 3, 11, 6, 1, 9, 4, 7, 2, 10])], exemplar)
    assert shuffled["order"] > 0.5
    assert min(shuffled["change"], shuffled["flicker"]) > 1.2
    blurred = measure((good[:, 1:-1] + good[:, :-2] + good[:, 2:]) / 3, exemplar)
    assert max(blurred["sharpness"], blurred["flicker"]) < 0.9
    for bad in (frozen, backwards, pingpong, shuffled, blurred):
        assert bad["overall"] > right["overall"] + 0.04


def test_what_happens_too_seldom_is_missed() -> None:
    quiet, busy = 0.1 * drifting(12), drifting(12, seed=5)
    both = torch.cat((quiet, busy), 3)
    figures = measure(torch.cat((busy, busy), 3), both)
    assert figures["forward"] < 0.15
    assert figures["coverage"] > 0.2
    assert figures["wasserstein"] > 0.2


def test_the_variogram_is_the_mean_square_step() -> None:
    """Brute force over all pairs, in the first of two bands and in the rest."""
    video = noise(2, 4, 11, 10)
    found = Variogram.of([video], 2)
    low = motion._smoothed(video, 1)
    for number, band in enumerate((video - low, low)):
        for column, lag in enumerate(motion.LAGS):
            steps = [(band[:, t + lag] - band[:, t]).square().mean() for t in range(4 - lag)]
            assert bool(found.still[number, column].isnan()) == (not steps)
            assert not steps or float(found.still[number, column]) == pytest.approx(sum(map(float, steps)) / len(steps))
        gamma = {}
        for y, x in itertools.product((-2, -1, 0, 1, 2), repeat=2):
            total, unit = [], 2**number
            for t, row, left in itertools.product(range(3), range(11), range(10)):
                if 0 <= row + y * unit < 11 and 0 <= left + x * unit < 10:
                    step = band[:, t + 1, row + y * unit, left + x * unit] - band[:, t, row, left]
                    total.append(float(step.square().mean()))
            gamma[y, x] = sum(total) / len(total)
        for column, (y, x) in enumerate([(0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0), (2, 2), (2, -2)]):
            odd = (gamma[y, x] - gamma[-y, -x]) / (gamma[y, x] + gamma[-y, -x])
            assert float(found.odd[number, column]) == pytest.approx(odd, abs=1e-5)


def test_what_moves_right_does_not_step_along_its_way() -> None:
    clip = drifting(6)[:, :, 4:-4]
    sky = torch.stack([clip[:, 0].roll(t, 2) for t in range(6)], 1)
    assert float(Variogram.of([sky[..., 6:]], 1).odd[0, 0]) == pytest.approx(-1, abs=1e-6)
    assert float(Variogram.of([sky[..., 6:].flip(1)], 1).odd[0, 0]) == pytest.approx(1, abs=1e-6)


def test_videos_are_read_block_by_block(monkeypatch: pytest.MonkeyPatch) -> None:
    videos = [noise(1, 20, 20, 20), noise(1, 3, 24, 20, seed=1)]
    whole = Variogram.of(videos, count_of_bands(videos))
    monkeypatch.setattr(motion, "BLOCK", 3)
    parts = Variogram.of(videos, count_of_bands(videos))
    for name in ("still", "odd", "even"):
        assert torch.allclose(getattr(whole, name), getattr(parts, name), atol=1e-9)


def test_a_clip_copied_to_another_place_and_time_is_replayed() -> None:
    exemplar, output = noise(1, 20, 24, 24), noise(1, 20, 24, 24, seed=1)
    assert matched(output, exemplar) == 0
    output[:, 4:14, 2:20, 3:23] = exemplar[:, 9:19, 5:23, 1:21]
    inside = (14 - 4 - 3) * (18 - 6) * (20 - 6) / (17 * 18 * 18)
    assert matched(output, exemplar) == pytest.approx(inside, abs=0.02)


def test_runs_shorter_than_eight_frames_are_free() -> None:
    exemplar = noise(1, 24, 20, 20)
    cut = [t for first in (16, 2, 10) for t in range(first, first + 7)]
    assert matched(exemplar[:, cut], exemplar) == 0
    cut = [t for first in (16, 0, 9) for t in range(first, first + 8)]
    within = (5 + 5 + 5) / 21  # windows of four frames over a cut are nobody's
    assert matched(exemplar[:, cut], exemplar) == pytest.approx(within, abs=0.01)


def test_what_stands_still_is_not_replayed() -> None:
    exemplar = torch.cat((noise(1, 12, 20, 20), noise(1, 1, 20, 20).expand(-1, 12, -1, -1)), 3)
    output = torch.cat((noise(1, 12, 20, 20, seed=1), exemplar[..., 20:]), 3)
    assert matched(output, exemplar) < 0.05


def test_a_loop_is_judged_by_its_join() -> None:
    turning = torch.stack([noise(1, 24, 24).roll(t, 2) for t in range(24)], 1)
    once, half = turning, turning[:, :12]
    assert measure(once, once)["loop"] <= 1.01
    assert measure(torch.cat((half, half.flip(1)), 1), once)["loop"] == 0


@pytest.mark.parametrize(("ours", "theirs"), list(itertools.product((1, 2, 3, 9), repeat=2)))
def test_clips_of_any_length_are_measured(ours: int, theirs: int) -> None:
    figures = measure(noise(1, ours, 12, 13), noise(1, theirs, 13, 12, seed=1))
    assert all(math.isfinite(value) and value >= 0 for value in figures.values())
    assert 0 < figures["overall"] < 1


def test_what_has_one_color_or_stands_still_is_measured() -> None:
    flat, still = torch.full((3, 5, 16, 16), 0.4), noise(3, 1, 16, 16).expand(-1, 5, -1, -1)
    for exemplar in (flat, still):
        figures = measure(exemplar, exemplar)
        assert figures["overall"] == pytest.approx(0, abs=1e-6)
        restless = measure(exemplar + 0.1 * noise(3, 5, 16, 16, seed=1), exemplar)
        assert all(math.isfinite(value) for value in restless.values())
        assert restless["change"] > 1
        assert restless["overall"] > 0.01


def test_each_of_several_clips_is_plausible() -> None:
    clips = [drifting(8), drifting(10, side=30, seed=3)]
    for clip in clips:
        figures = measure(clip, clips)
        assert figures["forward"] == pytest.approx(0, abs=1e-6)
        assert figures["coverage"] > 0.05


def test_a_video_beside_an_image_scores_the_mean_of_its_frames() -> None:
    exemplar = noise(1, 24, 24)
    assert "copy" in measure(noise(1, 3, 24, 24, seed=1), exemplar)
    assert "copy" in measure(exemplar, noise(1, 3, 24, 24, seed=1))


def test_figures_of_videos_do_not_depend_on_units() -> None:
    output, exemplar = drifting(6), drifting(6, seed=3)
    assert measure(output * 255, exemplar * 255) == pytest.approx(measure(output, exemplar), rel=1e-3)


def test_figures_of_videos_have_the_same_bits_for_any_number_of_threads() -> None:
    output, exemplar = drifting(9, 36), drifting(9, 36, seed=3)
    state = torch.random.get_rng_state()
    torch.set_num_threads(1)
    alone = measure(output, exemplar)
    torch.set_num_threads(2)
    together = measure(output, exemplar)
    assert alone == together
    assert torch.equal(torch.random.get_rng_state(), state)


def unfolded(video: Tensor, depth: int, scale: int = 1) -> Tensor:
    """All windows (n, C * depth * 49) of a video, by loops."""
    _, frames, height, width = video.shape
    span = 6 * scale + 1
    return torch.stack([
        video[:, t : t + depth, y : y + span : scale, x : x + span : scale].flatten()
        for t in range(frames - depth + 1) for y in range(height - span + 1) for x in range(width - span + 1)
    ])  # fmt: skip


def test_windows_of_several_videos_are_numbered_one_video_after_another() -> None:
    videos = [noise(2, 5, 9, 10), noise(2, 3, 11, 8, seed=1)]
    windows = Windows.of(videos, 7, 1, 3)
    assert torch.equal(windows.rows(torch.arange(len(windows))), torch.cat([unfolded(video, 3) for video in videos]))
    assert windows.places(torch.tensor([0, 13, 36]))[:, 1:].tolist() == [[0, 1], [1, 0], [0, 0], [1, 0]]


@pytest.mark.parametrize("part", [40, 9, 3])
def test_parts_of_videos_hold_every_window_once(part: int, monkeypatch: pytest.MonkeyPatch) -> None:
    videos = [noise(2, 6, 30, 29), noise(2, 4, 29, 28, seed=1)]
    windows = Windows.of(videos, 7, 4, 2)
    rows = windows.rows(torch.arange(len(windows)))
    project = Projection.learned_from(rows)
    monkeypatch.setattr(sys.modules[Windows.__module__], "PART", part)
    points = [project.all_windows(strip, windows) for _, strip in windows.strips()]
    firsts = [first for first, _ in windows.strips()]
    assert firsts == [0, *itertools.accumulate(map(len, points))][:-1]
    assert max(map(len, points)) <= part
    assert torch.allclose(torch.cat(points)[:, :-1], project(rows)[:, :-1], atol=1e-4)


def test_nearest_windows_of_videos_agree_with_brute_force() -> None:
    exemplar, output = drifting(9, 36), drifting(5, 12, seed=3)
    others, queries = unfolded(exemplar, 4), unfolded(output, 4)
    brute = torch.cdist(queries.double(), others.double()).min(1).values / queries.shape[1] ** 0.5
    found, _ = Nearest(Windows.of([exemplar], 7, 1, 4)).search(queries)
    assert (found >= brute - 1e-5).all()
    assert float(found.mean()) == pytest.approx(float(brute.mean()), rel=0.02)


def test_whitened_coordinates_have_unit_deviations() -> None:
    rows = noise(4000, 40) * torch.linspace(0.1, 5, 40)
    white = Projection.learned_from(rows).whitened(rows)
    assert torch.allclose(white.T.cov(), torch.eye(white.shape[1]), atol=1e-2)


def test_a_sample_of_a_video_is_spread_over_time_and_space() -> None:
    for video in (noise(1, 40, 30, 30), noise(1, 2, 60, 60)):
        windows = Windows.of([video], 7)
        sample = windows.sample(500)
        assert 400 < len(sample) < 900
        _, frame, row, column = windows.places(sample)
        for place, extent in zip((frame, row, column), windows.grids[0], strict=True):
            assert len(place.unique()) > 0.9 * extent


def test_bad_videos_are_named_with_their_cure() -> None:
    clip = noise(1, 3, 16, 16)
    for output, exemplar, message in (
        (noise(1, 3, 6, 16), clip, "output is 16x6 pixels; .* need at least 7"),
        (noise(3, 3, 16, 16), clip, "exemplar has 1 channels and output has 3"),
        (clip, clip.div(0), "exemplar holds NaN or infinite values"),
        (clip[:, :0], clip, "output is .*"),
    ):
        with pytest.raises(InputError, match=message):
            measure(output, exemplar)
