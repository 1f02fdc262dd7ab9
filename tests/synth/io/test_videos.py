"""Videos in and out of files."""

from pathlib import Path

import pytest
import torch

from kwatra.base.errors import InputError
from synth import Kind
from synth.io.videos import read_video, write_video

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


def test_odd_sizes_are_kept(tmp_path: Path) -> None:
    write_video(tmp_path / "odd.mp4", frames()[..., :15, :19], 25)
    assert read_video(tmp_path / "odd.mp4").frames.shape == (3, 5, 15, 19)


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


def test_a_folder_with_other_things_is_not_replaced(tmp_path: Path) -> None:
    write_video(tmp_path / "clip", frames(), 25)
    (tmp_path / "clip" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="more than frames"):
        write_video(tmp_path / "clip", frames(), 25, overwrite=True)
