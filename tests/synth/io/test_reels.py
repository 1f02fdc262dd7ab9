"""Frames read as they are looked at: the same as all at once, one held, in order decoded once."""

from pathlib import Path

import pytest
import torch
from torch import Tensor

from kwatra import InputError
from synth.io import reels
from synth.io.reels import Reel
from synth.io.videos import read_video, write_video


def noise(count: int) -> Tensor:
    return torch.rand(3, count, 16, 20, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("name", ["clip", "clip.mp4", "clip.gif"])
def test_frames_are_those_of_the_video_in_any_order(tmp_path: Path, name: str) -> None:
    write_video(tmp_path / name, noise(6), 25)
    whole = read_video(tmp_path / name).frames
    reel = Reel(tmp_path / name)
    assert len(reel) == 6
    for number in (0, 1, 1, 4, 2, 5, -1, 0):
        assert torch.equal(reel[number], whole[:, number])
    assert all(torch.equal(one, whole[:, 2 + at]) for at, one in enumerate(reel[2:4]))
    with pytest.raises(IndexError):
        reel[6]


def test_what_is_shown_of_frames(tmp_path: Path) -> None:
    write_video(tmp_path / "clip", noise(3), 25)
    assert torch.equal(Reel(tmp_path / "clip", lambda frame: frame[1])[2], read_video(tmp_path / "clip").frames[1, 2])


def test_in_order_each_frame_is_decoded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_video(tmp_path / "clip.mp4", noise(8), 25)
    reel, begun, decoded = Reel(tmp_path / "clip.mp4"), [], []
    frames = reels.file_frames

    def watched(*arguments: object, **named: object) -> object:
        begun.append(named)
        for frame in frames(*arguments, **named):  # type: ignore[arg-type]
            decoded.append(frame)
            yield frame

    monkeypatch.setattr(reels, "file_frames", watched)
    assert [float(frame.mean()) for frame in reel] == [float(reel[number].mean()) for number in range(8)]
    assert len(begun) == 2
    assert len(decoded) == 16
    assert begun[0] == {"aloud": False}  # what is left out of the file was told when it was first read


def test_what_cannot_be_read_is_refused_before_any_frame(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        Reel(tmp_path / "none.mp4")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="holds no images"):
        Reel(tmp_path / "empty")
    write_video(tmp_path / "clip.gif", noise(8), 25)
    data = (tmp_path / "clip.gif").read_bytes()
    (tmp_path / "clip.gif").write_bytes(data[:-1])
    with pytest.raises(InputError, match="cut off"):
        Reel(tmp_path / "clip.gif")
