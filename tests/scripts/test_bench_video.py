"""The benchmark and the gallery of video textures, shrunk."""

import json
from pathlib import Path

import bench_video
import gallery_video
import pytest
import torch
from linear_system import linear_system
from torch import Tensor

from synth import Kind, read_image
from synth.io.videos import read_video, write_video

RGB = Kind("uint8", ("R", "G", "B"))


def clip(frames: int = 6, side: int = 20) -> Tensor:
    """Blotches that drift to the right over others that stay."""
    generator = torch.Generator().manual_seed(0)
    coarse = torch.rand(2, 3, 1, 8, 10, generator=generator)
    sky, ground = torch.nn.functional.interpolate(coarse, (1, side, side + frames), mode="trilinear")
    return torch.cat([(sky[..., t : t + side] + ground[..., :side]) / 2 for t in range(frames, 0, -1)], 1)


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    folder = tmp_path / "clips"
    folder.mkdir()
    write_video(folder / "drift", clip(), 25, RGB)
    return folder


def test_every_method_is_judged_beside_the_others(clips: Path, tmp_path: Path, capsys) -> None:
    out, figures = tmp_path / "out", tmp_path / "figures.json"
    assert bench_video.main([str(clips), "--out", str(out), "--json", str(figures)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    rows = {row["method"]: row["figures"] for row in json.loads(figures.read_text())}
    assert list(rows) == ["unseen", *bench_video.METHODS]
    assert all(list(each) == ["cpu", *bench_video.FIGURES] for each in rows.values())
    assert rows["loop"]["replay"] > 0.5 > 0.3 > rows["published"]["replay"]
    for method in bench_video.METHODS:
        assert f"drift  {method}" in said.out
        assert read_video(out / f"drift_{method}").frames.shape == (3, 12, 20, 20)
        assert read_image(out / f"drift_{method}.png").pixels.std() > 0.02
    assert (out / "drift.png").is_file()


def test_what_a_method_cannot_make_is_left_out(clips: Path, tmp_path: Path, capsys) -> None:
    words = [str(clips / "drift"), "--methods", "loop", "linear", "--size", "24x22", "--out", str(tmp_path / "out")]
    assert bench_video.main(words) == 0
    assert "drift  linear is left out: a linear dynamic system keeps its clip's size" in capsys.readouterr().out
    looped = read_video(tmp_path / "out" / "drift_loop").frames
    assert looped.shape == (3, 12, 22, 24)
    assert torch.equal(looped[:, 6:], looped[:, :6])
    assert torch.equal(looped[..., 20:], looped[..., :4])


def test_bad_input_is_one_sentence(tmp_path: Path, capsys) -> None:
    for script in (bench_video, gallery_video):
        assert script.main([str(tmp_path / "none.mp4"), "--out", str(tmp_path)]) == 2
        assert f"{script.__name__}: {tmp_path / 'none.mp4'} does not exist" in capsys.readouterr().err


def test_the_published_method_is_the_engine_without_its_start() -> None:
    task = bench_video.Task(clip(), (5, 18, 22), 0)
    made = bench_video.as_published(task)
    assert made.shape == (3, 5, 18, 22)
    assert torch.equal(made, bench_video.as_published(task))
    assert not torch.equal(made, bench_video.by_engine(task))


def test_a_linear_system_goes_on_as_its_clip_does() -> None:
    """A wave that travels is a rotation of two components, which the fit finds exactly."""
    t, x = torch.meshgrid(torch.arange(24.0), torch.arange(16.0), indexing="ij")
    wave = (0.5 + 0.4 * torch.sin(2 * torch.pi * (t / 12 + x / 16)))[None, :, None].expand(3, -1, 4, -1)
    made = linear_system(wave, 12)
    assert torch.allclose(made, wave[:, :12], atol=0.02)  # the largest eigenvalue is kept below 1
    noisy = (wave + 0.05 * torch.rand(wave.shape, generator=torch.Generator().manual_seed(0))).clamp(0, 1)
    long = linear_system(noisy, 200, seed=3)
    assert torch.equal(long, linear_system(noisy, 200, seed=3))
    assert not torch.equal(long, linear_system(noisy, 200, seed=4))
    assert 0.1 < float(long[:, -50:].std()) < 0.5


def test_the_gallery_shows_the_clip_above_what_is_made(clips: Path, tmp_path: Path, capsys) -> None:
    assert gallery_video.main([str(clips), "--frames", "8", "--out", str(tmp_path)]) == 0
    figure = read_image(tmp_path / "figure_26_drift.png").pixels
    assert torch.allclose(figure[:, :20, :20], clip()[:, 0], atol=0.01)
    assert read_video(tmp_path / "figure_26_drift.mp4").frames.shape == (3, 8, 20, 20)
