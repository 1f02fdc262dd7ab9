"""Videos in and out of files."""

import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import torch
from torch import Tensor

from kwatra.base.errors import InputError
from synth import Kind, write_image
from synth.io import alpha_videos
from synth.io.reels import Reel
from synth.io.videos import is_video, read_video, write_video, written_like

GRAY16 = Kind("uint16", ("Y",))


def frames(channels: int = 3) -> torch.Tensor:
    """A gradient that moves, (channels, 5, 16, 20)."""
    t, y, x = torch.meshgrid(torch.arange(5), torch.arange(16), torch.arange(20), indexing="ij")
    return ((x + y + 2 * t) / 45).expand(channels, -1, -1, -1).contiguous()


def test_a_folder_keeps_every_value(tmp_path: Path) -> None:
    exact = (frames(1) * 65535).round() / 65535
    write_video(tmp_path / "clip", exact, 25, GRAY16)
    clip = read_video(tmp_path / "clip", rate=12)
    torch.testing.assert_close(clip.frames, exact, rtol=0, atol=1e-7)
    assert (clip.rate, clip.kind) == (12, GRAY16)


@pytest.mark.parametrize(("name", "tolerance"), [("clip.mp4", 0.04), ("clip.gif", 0.04)])
def test_a_file_keeps_size_length_rate_and_looks(tmp_path: Path, name: str, tolerance: float) -> None:
    write_video(tmp_path / name, frames(), 20)
    clip = read_video(tmp_path / name)
    assert clip.frames.shape == (3, 5, 16, 20)
    assert clip.rate == pytest.approx(20)
    torch.testing.assert_close(clip.frames, frames(), rtol=0, atol=tolerance)


def write_unwritten(path: Path, video: Tensor, codec: str) -> None:
    """A video (C, T, H, W) in a container that `write_video` does not write."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=25)
        stream.height, stream.width, stream.pix_fmt, stream.bit_rate = *video.shape[2:], "yuv420p", 1_000_000
        for picture in (video * 255).byte().permute(1, 2, 3, 0).numpy():
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


@pytest.mark.parametrize("suffix", [".mkv", ".avi", ".m4v", ".mpg", ".flv"])
def test_files_that_are_not_written_are_read(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"clip{suffix}"
    write_unwritten(path, frames(), {".mpg": "mpeg2video", ".flv": "flv1"}.get(suffix, "mpeg4"))
    assert is_video(path)
    clip = read_video(path)
    assert clip.rate == pytest.approx(25)
    torch.testing.assert_close(clip.frames, frames(), rtol=0, atol=0.06)


def test_a_gif_of_one_frame_is_a_picture_in_whatever_way_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "still.gif"
    write_video(path, frames()[:, :1], 25)
    for read in (read_video, Reel):
        with pytest.raises(InputError, match="is a still picture but GIF is read as video; convert it to PNG"):
            read(path)
    write_video(tmp_path / "still.mp4", frames()[:, :1], 25)
    assert read_video(tmp_path / "still.mp4").frames.shape[1] == 1


def test_videos_are_written_like_others_where_that_can_be(tmp_path: Path) -> None:
    assert [written_like(Path(name)) for name in ("a.mkv", "a.MP4", "a.webm", "a.avi")] == [
        ".mp4", ".MP4", ".webm", ".mp4"]  # fmt: skip
    assert written_like(tmp_path) == ""


def test_an_odd_side_gains_a_pixel_that_repeats_the_last(tmp_path: Path) -> None:
    write_video(tmp_path / "odd.mp4", frames()[..., :15, :19], 25)
    made = read_video(tmp_path / "odd.mp4").frames
    assert made.shape == (3, 5, 16, 20)
    torch.testing.assert_close(made[..., :15, :19], frames()[..., :15, :19], rtol=0, atol=0.04)
    torch.testing.assert_close(made[..., 15, :19], made[..., 14, :19], rtol=0, atol=0.04)


def test_colors_are_those_that_the_file_says(tmp_path: Path) -> None:
    colors = torch.tensor([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.5, 0.8]])
    bars = colors.T[:, None, None, :].repeat_interleave(16, 3).expand(3, 3, 16, 64)
    write_video(tmp_path / "bars.mp4", bars, 25)
    with av.open(str(tmp_path / "bars.mp4")) as container:
        context = container.streams.video[0].codec_context
        assert (context.profile, context.pix_fmt) == ("High", "yuv420p")
        assert (context.color_range, context.colorspace, context.color_primaries, context.color_trc) == (1, 1, 1, 1)
    middle = read_video(tmp_path / "bars.mp4").frames[:, 1, 8, 8::16]
    torch.testing.assert_close(middle, colors.T, rtol=0, atol=0.02)


def test_the_same_frames_are_the_same_file_whatever_memory_held_and_on_any_number_of_cores(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = """
import os, torch
from synth.io.videos import write_video
for cells in (12, 32):  # small frames show what memory held, larger ones into how many parts cores cut them
    blocks = torch.rand(3, 1, cells, cells, generator=torch.Generator().manual_seed(0))
    blocks = blocks.repeat_interleave(8, 2).repeat_interleave(8, 3)
    frames = torch.cat([blocks.roll(t, 3) for t in range(12)], 1)
    write_video(f"{os.environ.get('MALLOC_PERTURB_')}_{cells}.mp4", frames, 25)
"""
    alone = "import os; hasattr(os, 'sched_setaffinity') and os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
    root = str(Path(__file__).parents[3])
    environment = os.environ | {"PYTHONPATH": root, "MALLOC_PERTURB_": "37"}  # what glibc fills memory with
    subprocess.run([sys.executable, "-c", alone + program], check=True, env=environment, cwd=tmp_path)
    monkeypatch.chdir(tmp_path)
    exec(program, {})
    for cells in (12, 32):
        written = (tmp_path / f"37_{cells}.mp4").read_bytes()
        assert written == (tmp_path / f"None_{cells}.mp4").read_bytes()
        assert b" threads=1 " in written  # as the encoder tells in the file: not every release shows the difference
        assert b" mbtree=0 " in written


def test_nothing_is_left_of_a_video_that_could_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_video(tmp_path / "clip", frames(), 25)
    before = read_video(tmp_path / "clip").frames

    def fail(*anything: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("synth.io.videos.image_writer", fail)
        with pytest.raises(KeyboardInterrupt):
            write_video(tmp_path / "clip", frames() * 0, 25, overwrite=True)
    assert [p.name for p in tmp_path.iterdir()] == ["clip"]
    torch.testing.assert_close(read_video(tmp_path / "clip").frames, before)


def test_sound_and_frames_that_last_differently_are_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, uneven, loud in (("even.mp4", 1, False), ("uneven.mp4", 3, False), ("loud.mp4", 1, True)):
        with av.open(str(tmp_path / name), "w") as container:
            stream = container.add_stream("libx264", rate=25)
            sound = container.add_stream("aac", rate=8000) if loud else None
            stream.width, stream.height, stream.pix_fmt, stream.time_base = 20, 16, "yuv420p", Fraction(1, 25)
            for t, picture in enumerate((frames() * 255).byte().permute(1, 2, 3, 0).numpy()):
                frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
                frame.pts, frame.time_base = t if t < 3 else 2 + uneven * (t - 2), Fraction(1, 25)
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
            if sound is not None:
                quiet = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
                quiet.sample_rate = 8000
                container.mux(sound.encode(quiet))
                container.mux(sound.encode(None))
    told = []
    for name in ("even", "uneven", "loud"):
        assert read_video(tmp_path / f"{name}.mp4").frames.shape == (3, 5, 16, 20)
        told.append(capsys.readouterr().err)
    assert told[0] == ""
    assert "uneven.mp4 shows its frames for 0.04 to 0.12 s each; all are taken to last alike" in told[1]
    assert told[2].endswith("loud.mp4 has sound, which is left out\n")


@pytest.mark.parametrize(("name", "sentence"), [
    ("clip.webm", "clip.webm ends after .* of the 0.48 s that it says it has; give the whole file"),
    ("clip.gif", "clip.gif is cut off, it lacks the end of a GIF; give the whole file"),
    ("clip.mp4", r"clip.mp4 is no video that can be read \(Invalid data"),
    ("clip.mpg", "clip.mpg is damaged or cut off, it has a frame that is not whole; give the whole file"),
])  # fmt: skip
def test_a_file_that_was_cut_off_is_refused(tmp_path: Path, name: str, sentence: str) -> None:
    noise = torch.rand(3, 12, 16, 20, generator=torch.Generator().manual_seed(0))
    if name == "clip.mpg":
        write_unwritten(tmp_path / name, noise, "mpeg2video")
    else:
        write_video(tmp_path / name, noise, 25)
    assert read_video(tmp_path / name).frames.shape[1] == 12
    data = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(data[:-1] if name == "clip.gif" else data[: len(data) // 2])
    with pytest.raises(InputError, match=sentence):
        read_video(tmp_path / name)


@pytest.mark.parametrize("name", ["clip", "clip.mp4", "clip.webm", "clip.mov"])
def test_a_video_may_have_one_frame(tmp_path: Path, name: str) -> None:
    write_video(tmp_path / name, frames()[:, :1], 25)
    clip = read_video(tmp_path / name)
    assert clip.frames.shape[1] == 1
    assert clip.rate > 0


def test_a_file_in_an_unknown_code_is_refused(tmp_path: Path) -> None:
    write_video(tmp_path / "clip.mp4", frames(), 25)
    (tmp_path / "clip.mp4").write_bytes((tmp_path / "clip.mp4").read_bytes().replace(b"avc1", b"none"))
    with pytest.raises(InputError, match=r"clip\.mp4 holds no video that can be read; give"):
        read_video(tmp_path / "clip.mp4")


def test_a_folder_with_other_things_is_not_replaced(tmp_path: Path) -> None:
    write_video(tmp_path / "clip", frames(), 25)
    (tmp_path / "clip" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="more than frames"):
        write_video(tmp_path / "clip", frames(), 25, overwrite=True)


@pytest.mark.parametrize(("suffix", "near"), [(".webm", 0.03), (".mov", 0.004)])
def test_alpha_is_kept_and_the_same_frames_are_the_same_file(tmp_path: Path, suffix: str, near: float) -> None:
    noise = torch.rand(1, 4, 6, 8, generator=torch.Generator().manual_seed(0))
    picture = torch.nn.functional.interpolate(noise, (33, 47), mode="bicubic")[0].clamp(0, 1)
    frames = torch.stack([picture.roll(t, 2) for t in range(4)], 1)
    kind = Kind("uint8", ("R", "G", "B", "A"))
    for name in "ab":
        write_video(tmp_path / f"{name}{suffix}", frames, 12.5, kind)
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()
    clip = read_video(tmp_path / f"a{suffix}")
    assert (clip.kind, clip.rate) == (kind, 12.5)
    assert float((clip.frames[3] - frames[3]).abs().mean()) < 0.005
    assert float((clip.frames - frames).abs().mean()) < near
    write_video(tmp_path / f"c{suffix}", frames[:3], 25, Kind("uint8", ("R", "G", "B")))
    assert read_video(tmp_path / f"c{suffix}").frames.shape == (3, 4, 33, 47)


def test_a_missing_encoder_is_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(alpha_videos._CODECS, ".webm", "none")
    with pytest.raises(InputError, match="needs the encoder none, which this PyAV lacks"):
        write_video(tmp_path / "a.webm", torch.zeros(3, 2, 16, 16), 25)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_what_is_transparent_is_black_where_there_is_no_alpha(tmp_path: Path, suffix: str) -> None:
    alpha = (frames(1) > 0.5).float()
    write_video(
        tmp_path / f"a{suffix}", torch.cat([torch.ones(3, *alpha.shape[1:]), alpha]), 25, Kind("uint8", tuple("RGBA"))
    )
    assert float((read_video(tmp_path / f"a{suffix}").frames - alpha).abs().mean()) < 0.05


def test_frames_are_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    tones = torch.arange(12) / 255
    for number, tone in enumerate(tones.tolist()):
        write_image(tmp_path / f"frame {number}.png", torch.full((1, 4, 4), tone), Kind("uint8", ("Y",)))
    torch.testing.assert_close(read_video(tmp_path).frames[0, :, 0, 0], tones)
