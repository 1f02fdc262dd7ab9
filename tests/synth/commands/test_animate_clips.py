"""`kwatra animate` of videos."""

from pathlib import Path

import numpy as np
import pytest
import torch
from sand import GRAY, SHAPE, frames_of, interrupted, texture, written

import flow
from kwatra import Exemplar
from synth import read_image
from synth.cli import main
from synth.io.videos import read_video, write_video
from synth.texture.work import PRESETS


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with an exemplar and a flow."""
    monkeypatch.chdir(tmp_path)
    written()
    return tmp_path


@pytest.fixture
def clip(folder: Path) -> torch.Tensor:
    """Frames (1, 5, 40, 48) of a texture that changes in place, as a folder, living."""
    start, end = (texture(size=48)[:, :40], texture(size=48).flip(2)[:, :40])
    frames = torch.stack([torch.lerp(start, end, t / 4) for t in range(5)], 1)
    write_video("living", frames, 10.0, GRAY)
    return frames


VIDEO = ["animate", "living", "--flow", "rotation", "--preset", "fast", "--speed", "1"]


def test_a_video_is_animated_at_its_own_size_and_rate(clip: torch.Tensor, folder: Path) -> None:
    write_video("living.gif", clip, 10.0)
    assert main([*VIDEO, "--frames", "3", "-o", "out"]) == 0
    read = read_video("living").frames
    low, high = float(read.min()), float(read.max())
    expected = flow.animate(
        ((read.double() - low) / (high - low)).float(), flow.rotation(1.0), SHAPE, frames=3,
        renewing=flow.VIDEO_PRESETS["fast"], synthesis=PRESETS["fast"][0],
    )  # fmt: skip
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main(["animate", "living.gif", *VIDEO[2:], "--frames", "2", "-o", "out.mp4"]) == 0
    assert read_video("out.mp4").rate == pytest.approx(10.0)


@pytest.mark.parametrize("name", ["sand.png", "living"])
def test_copies_of_the_exemplar_are_used_on_request(clip: torch.Tensor, folder: Path, name: str) -> None:
    command = ["animate", name, "--flow", "rotation", "--preset", "fast", "--size", "48x40", "--frames", "2"]
    assert main([*command, "--mirror", "--rotate=90,180", "--scale", "0.8", "-o", "out"]) == 0
    pixels = read_image(name).pixels if name.endswith("png") else read_video(name).frames
    low, high = float(pixels.min()), float(pixels.max())
    exemplar = Exemplar.of(((pixels.double() - low) / (high - low)).float(), mirror=True, rotate=(90, 180), scale=[0.8])
    presets = flow.PRESETS if pixels.ndim == 3 else flow.VIDEO_PRESETS
    expected = flow.animate(exemplar, flow.rotation(2.0), SHAPE, frames=2, renewing=presets["fast"],
                            synthesis=PRESETS["fast"][0])  # fmt: skip
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main([*command[:-1], "3", "-o", "out", "--resume"]) == 2


def test_maps_of_directions_are_not_turned_with_variants(clip: torch.Tensor, folder: Path, capsys) -> None:
    write_video("normals", clip, 10.0, GRAY)
    assert main([*VIDEO, "--also", "normal=normals", "--mirror", "-o", "out"]) == 2
    assert "--also normal holds directions" in capsys.readouterr().err


def test_a_video_is_gone_on_with_and_loops(clip: torch.Tensor, folder: Path) -> None:
    assert main([*VIDEO, "--frames", "4", "-o", "whole"]) == 0
    assert main([*VIDEO, "--frames", "2", "-o", "part"]) == 0
    assert main([*VIDEO, "--frames", "4", "-o", "part", "--resume"]) == 0
    assert frames_of("part") == frames_of("whole")
    assert main([*VIDEO, "--loop", "4", "-o", "round"]) == 0
    assert main([*VIDEO, "--frames", "3", "--fill-from", "all", "--obstacle", "disc", "-o", "wet"]) == 0


def test_a_flow_in_time_says_how_long_the_animation_is(clip: torch.Tensor, folder: Path) -> None:
    np.save("gust.npy", np.zeros((2, 2, *SHAPE), np.float32))
    assert main(["animate", "living", "--flow", "gust.npy", "--preset", "fast", "-o", "out"]) == 0
    assert len(list(Path("out").glob("*.png"))) == 3


@pytest.mark.parametrize("how", ["--preset=fast", "--published"])
def test_a_clip_of_one_frame_flows(clip: torch.Tensor, folder: Path, how: str) -> None:
    write_video("one", clip[:, :1], 10.0, GRAY)
    assert main(["animate", "one", "--flow", "rotation", how, "--frames", "2", "--size", "24x20", "-o", "out"]) == 0
    made = read_video("out").frames
    assert made.shape == (1, 2, 20, 24)
    assert not torch.equal(made[:, 0], made[:, 1])


def test_a_video_that_cannot_be_read_is_refused(
    clip: torch.Tensor, folder: Path, capsys: pytest.CaptureFixture
) -> None:
    Path("none").mkdir()
    assert main(["animate", "none", "--flow", "rotation"]) == 2
    assert "none holds no images" in capsys.readouterr().err


def test_a_video_flows_as_published(
    clip: torch.Tensor, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["animate", "living", "--flow", "uniform:90", "--speed", "1", "--size", "24x24", "--published"]
    assert main([*command, "--frames", "4", "-o", "whole"]) == 0
    read = read_video("living").frames
    low, high = float(read.min()), float(read.max())
    for number, frame in enumerate(
        flow.published(((read.double() - low) / (high - low)).float(), flow.uniform(1.0, 90), (24, 24), 4)
    ):
        made = read_image(f"whole/{number:06d}.png").pixels
        torch.testing.assert_close(made, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main([*command, "--frames", "4", "--rotate", "90", "-o", "turned"]) == 0
    assert frames_of("turned") != frames_of("whole")
    with monkeypatch.context() as patch:
        interrupted(patch, "published", 2)
        assert main([*command, "--frames", "4", "-o", "part"]) == 130
    assert len(frames_of("part")) == 2
    assert main([*command, "--frames", "4", "-o", "part", "--resume"]) == 0
    assert frames_of("part") == frames_of("whole")
    capsys.readouterr()
    for more, said in (
        (["--preset", "fast"], "--preset says how to renew, but what was --published renews nothing"),
        (["--turn", "on"], "--turn is of copies that are carried, but what was --published carries none"),
        (["--fill-from", "left"], "--fill-from begins an animation, but what was --published has no such"),
    ):
        assert main([*command, *more]) == 2
        assert said in capsys.readouterr().err
    assert main(["animate", "sand.png", "--flow", "rotation", "--published", "--loop", "4"]) == 2
    assert "neither loops nor flows around obstacles" in capsys.readouterr().err
