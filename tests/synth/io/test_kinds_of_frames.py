"""Folders whose images are of several kinds, and what becomes of kinds that a video file cannot hold."""

from pathlib import Path

import numpy as np
import pytest
import torch

from kwatra.base.errors import InputError
from synth import Kind, write_image
from synth.io.images import read_array
from synth.io.videos import extremes_of, read_video, write_video

GRAY, DEEP = Kind("uint8", ("Y",)), Kind("uint16", ("R", "G", "B"))
FLOATS = Kind("float32", ("R", "G", "B"))


def noise(*shape: int) -> torch.Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("first", [0, 1])
def test_frames_of_several_kinds_are_raised_to_the_richest(tmp_path: Path, first: int) -> None:
    gray, deep = (noise(1, 6, 8) * 255).round() / 255, (noise(3, 6, 8) * 65535).round() / 65535
    write_image(tmp_path / f"{first}.png", gray, GRAY)
    write_image(tmp_path / f"{1 - first}.png", deep, DEEP)
    clip = read_video(tmp_path)
    assert clip.kind == DEEP
    assert torch.equal(clip.frames[:, first], gray.expand(3, -1, -1))
    assert torch.equal(clip.frames[:, 1 - first], deep)


def test_frames_of_several_sizes_are_refused(tmp_path: Path) -> None:
    for number, width in enumerate((8, 9)):
        write_image(tmp_path / f"{number}.png", noise(1, 6, width), GRAY)
    with pytest.raises(InputError, match=r"1.png is 9x6 but 0.png is 8x6; all frames must have one size"):
        read_video(tmp_path)


def test_a_video_file_shows_floats_from_the_least_to_the_largest_and_a_folder_keeps_them(tmp_path: Path) -> None:
    ramp = (torch.arange(32.0).expand(3, 4, 32, -1) / 31) * 9 - 3  # -3 to 6
    assert extremes_of(FLOATS, [ramp, 2 * ramp]) == (-6, 12)
    assert extremes_of(GRAY, [ramp]) == (0, 1)
    for name in ("a.mp4", "a.mov", "a"):
        write_video(tmp_path / name, ramp, 25, FLOATS)
    for name in ("a.mp4", "a.mov"):
        shown = read_video(tmp_path / name).frames
        torch.testing.assert_close(shown, (ramp + 3) / 9, rtol=0, atol=0.04)
    assert torch.equal(read_video(tmp_path / "a").frames, ramp)


@pytest.mark.parametrize("kind", [Kind("uint8", ("Y", "X1", "X2", "X3", "X4")), Kind("bool", ("Y",))])
def test_a_folder_holds_frames_of_any_kind(tmp_path: Path, kind: Kind) -> None:
    frames = noise(len(kind.channels), 2, 6, 8).round()
    write_video(tmp_path / "a", frames, 25, kind)
    clip = read_video(tmp_path / "a")
    assert (clip.kind, torch.equal(clip.frames, frames)) == (kind, True)
    first = sorted((tmp_path / "a").iterdir())[0]
    assert first.suffix == (".png" if kind.dtype == "bool" else ".tif")
    assert read_array(first)[0].dtype == np.dtype(kind.dtype)
