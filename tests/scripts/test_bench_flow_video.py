"""The benchmark of videos that flow: its figures on known motion, and its table."""

import bench_flow_video
import pytest
import torch
from bench_flow_video import Task, figures_of
from gallery_quilting import waves

import flow
from kwatra import InputError


def test_an_exact_motion_has_no_error_and_no_life() -> None:
    clip = waves(4, 48)
    task = Task(clip, flow.uniform(2.0), (48, 48), 4, 4)
    figures = figures_of(bench_flow_video.exactly(task), task)
    assert figures["epe"] < 0.1
    assert figures["life"] < 0.1
    assert figures["agitation"] < 0.2
    assert figures["sharp"] == pytest.approx(1.0, abs=0.2)


def test_the_clip_itself_lives_as_it_does() -> None:
    clip = waves(4, 48)
    own = bench_flow_video.motions(bench_flow_video.steps(clip)).mean(0)
    figures = figures_of(clip, Task(clip, flow.sampled(own), (48, 48), 4, 4))
    assert figures["life"] == pytest.approx(1.0, rel=0.01)
    assert figures["agitation"] == pytest.approx(1.0, rel=0.01)
    assert figures["epe mean"] == pytest.approx(0.0, abs=1e-5)


def test_the_truth_moves_by_the_field_alone_and_lives() -> None:
    clip = waves(6, 64)
    task = Task(clip, flow.uniform(2.0), (64, 64), 6, 6)
    made = bench_flow_video.truly(task)
    assert [part.shape for part in made] == [(3, 5, 32, 32)] * 2
    figures = figures_of(made, task)
    own = figures_of(bench_flow_video.middle(clip), task)
    assert figures["epe mean"] < 0.5 * own["epe mean"]
    assert figures["life"] > 0.5
    exact = figures_of(bench_flow_video.middle(bench_flow_video.exactly(task)), task)
    assert exact["life"] < 0.5 * figures["life"]


def test_of_a_clip_that_only_moves_the_truth_is_the_exact_motion() -> None:
    sheet = waves(1, 96)[:, 0]
    clip = torch.stack([sheet[:, 16:80, 30 - 3 * t : 94 - 3 * t] for t in range(6)], 1)
    task = Task(clip, flow.uniform(2.0, 90), (64, 64), 6, 6)
    figures = figures_of(bench_flow_video.truly(task), task)
    assert figures["epe"] < 0.15
    assert figures["sharp"] == pytest.approx(1.0, abs=0.1)


def test_a_clip_is_panned_as_a_uniform_field_flows() -> None:
    still = waves(1, 64).expand(-1, 6, -1, -1)
    task = Task(still, flow.uniform(2.0, 30), (64, 64), 6, 6)
    made = bench_flow_video.panned(task)
    assert made.shape == (3, 6, 64, 64)
    figures = figures_of(made, task)
    assert figures["epe"] < 0.1
    assert figures["sharp"] == pytest.approx(1.0, abs=0.1)
    assert figures["overall"] > 0
    still = waves(1, 64).expand(-1, 9, -1, -1)
    far = bench_flow_video.panned(Task(still, flow.uniform(16.0), (64, 64), 9, 9))
    torch.testing.assert_close(far[:, 4], still[:, 4].flip(2))
    torch.testing.assert_close(far[:, 8], still[:, 8])
    with pytest.raises(InputError, match="only uniform fields are panned"):
        bench_flow_video.panned(Task(still, flow.rotation(2.0), (64, 64), 6, 6))


def test_of_panned_footage_no_motion_is_read(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(bench_flow_video, "waves", lambda frames, side: waves(4, 40))
    words = ["--fields", "uniform", "--methods", "panned", "--out", str(tmp_path)]
    assert bench_flow_video.main(words) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("waves uniform"))
    assert row.split()[3:7] == ["-"] * 4
    assert "-" not in row.split()[7:]


def test_the_table_has_a_row_for_every_method(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(bench_flow_video, "waves", lambda frames, side: waves(4, 40))
    words = ["--fields", "rotation", "--methods", "kwatra", "exact", "--frames", "3", "--size", "40x32"]
    assert bench_flow_video.main([*words, "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("kwatra", "exact", "agitation"))
    assert {path.name for path in tmp_path.iterdir()} == {f"waves_rotation_{m}.png" for m in ("kwatra", "exact")}
