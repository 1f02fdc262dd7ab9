"""The benchmark of holes in videos, shrunk."""

import json
from pathlib import Path

import bench_fill_video
import pytest
import torch

from synth import Kind
from synth.io.videos import read_video, write_video

RGB = Kind("uint8", ("R", "G", "B"))


def clip(frames: int = 5, side: int = 20) -> torch.Tensor:
    return torch.rand(3, frames, side, side, generator=torch.Generator().manual_seed(0))


def test_the_truth_is_perfect_and_a_blur_is_seen() -> None:
    video, hole = clip(), bench_fill_video.disc(clip(), 0.3)
    assert hole.sum() == pytest.approx(torch.pi * 36, rel=0.1)
    assert bench_fill_video.figures(video, video, hole) == {"sharpness": 1, "change": 1, "border": 1, "off": 0}
    flat = torch.where(hole, 0.5, video)
    seen = bench_fill_video.figures(flat, video, hole)
    assert seen["sharpness"] == seen["change"] == 0
    assert seen["off"] == pytest.approx(1, abs=0.05)
    other = torch.where(hole, video.flip(2), video)
    assert bench_fill_video.figures(other, video, hole)["off"] == pytest.approx(2**0.5, abs=0.1)


def test_clips_are_filled_and_judged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "clips").mkdir()
    write_video(tmp_path / "clips" / "noise", clip(), 25, RGB)
    out, file = tmp_path / "out", tmp_path / "figures.json"
    words = [str(tmp_path / "clips"), "--out", str(out), "--preset", "fast", "--json", str(file)]
    assert bench_fill_video.main(words) == 0
    assert "noise" in capsys.readouterr().out
    (row,) = json.loads(file.read_text())
    assert 0.5 < row["figures"]["sharpness"] < 1.2
    assert read_video(out / "noise").frames.shape == (3, 5, 20, 20)
    assert (out / "noise.png").is_file()


def test_a_clip_of_one_frame_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_video(tmp_path / "still", clip(1), 25, RGB)
    assert bench_fill_video.main([str(tmp_path / "still"), "--out", str(tmp_path / "out")]) == 2
    assert "too few for a hole" in capsys.readouterr().err
