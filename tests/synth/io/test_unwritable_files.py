"""Images that cannot be written say so in one sentence, and whatever was there stays."""

import errno
import io
import os
import warnings
from pathlib import Path

import pytest
import torch
from arrays import GRAY, RGB, RGBA
from PIL import Image

from kwatra import InputError
from synth import Kind, read_image, write_image
from synth.io.images import write_files


@pytest.mark.parametrize(
    ("name", "kind", "cure"),
    [
        ("a.jpg", Kind("uint16", RGB), r"cannot hold uint16 RGB pixels; end it with \.png or \.tif or \.tiff"),
        ("a.jpg", Kind("uint8", RGBA), r"cannot hold uint8 RGBA pixels; end it with \.png"),
        ("a.png", Kind("float32", RGB), r"cannot hold float32 RGB pixels; end it with \.tif or \.tiff or \.exr"),
        ("a.exr", Kind("uint8", RGB), r"cannot hold uint8 RGB pixels; end it with \.png"),
        ("a.png", Kind("uint8", ("Y", "X1", "X2", "X3", "X4")), r"cannot hold .*; end it with \.tif"),
        ("a.gif", Kind("uint8", RGB), r"a\.gif has an ending that cannot hold"),
        ("a", Kind("uint8", RGB), "has an ending that cannot hold"),
    ],
)
def test_format_that_cannot_hold_the_kind(tmp_path: Path, name: str, kind: Kind, cure: str) -> None:
    with pytest.raises(InputError, match=cure):
        write_image(tmp_path / name, torch.zeros(len(kind.channels), 8, 8), kind)
    assert not list(tmp_path.iterdir())


def test_wrong_number_of_channels(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"pixels have shape \(1, 8, 8\); give \(C, H, W\) with 3 channels"):
        write_image(tmp_path / "a.png", torch.zeros(1, 8, 8), Kind("uint8", RGB))


def test_existing_file_is_kept_unless_allowed(tmp_path: Path) -> None:
    path, kind = tmp_path / "a.png", Kind("uint8", GRAY)
    write_image(path, torch.zeros(1, 8, 8), kind)
    before = path.read_bytes()
    with pytest.raises(InputError, match=r"a\.png exists; name another file or allow it with --overwrite"):
        write_image(path, torch.ones(1, 8, 8), kind)
    assert path.read_bytes() == before
    write_image(path, torch.ones(1, 8, 8), kind, overwrite=True)
    assert read_image(path).pixels.min() == 1


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"because the folder .*nowhere does not exist; make it first"):
        write_image(tmp_path / "nowhere" / "a.png", torch.zeros(1, 8, 8), Kind("uint8", GRAY))


def test_target_that_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "a.png").mkdir()
    with pytest.raises(InputError, match="is a folder; name a file"):
        write_image(tmp_path / "a.png", torch.zeros(1, 8, 8), Kind("uint8", GRAY), overwrite=True)


@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_full_disk_leaves_everything_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    path, kind = tmp_path / f"a{suffix}", Kind("uint8" if suffix == ".png" else "float32", GRAY)
    write_image(path, torch.zeros(1, 8, 8), kind)
    before = path.read_bytes()

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="was not written because the disk is full; free some space"):
        write_image(path, torch.ones(1, 8, 8), kind, overwrite=True)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize(("suffix", "dtype"), [(".png", "uint8"), (".tif", "uint8"), (".exr", "float32")])
def test_device_that_is_always_full(tmp_path: Path, suffix: str, dtype: str) -> None:
    from synth.io.images import image_writer

    target = tmp_path / f"a{suffix}"
    write = image_writer(target, torch.zeros(3, 8, 8), Kind(dtype, RGB))  # small: OpenEXR itself notices large ones
    with pytest.raises(InputError, match=r"was not written .*disk"):
        write_files({target: lambda _: write(Path("/dev/full"))}, overwrite=False)
    assert not list(tmp_path.iterdir())


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target, link = tmp_path / "real" / "a.png", tmp_path / "link.png"
    target.touch()
    link.symlink_to(target)
    write_image(link, torch.zeros(1, 8, 8), Kind("uint8", GRAY), overwrite=True)
    assert link.is_symlink()
    assert target.stat().st_size > 0


def test_written_files_have_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "usual").touch()
    write_image(tmp_path / "a.png", torch.zeros(1, 8, 8), Kind("uint8", GRAY))
    assert (tmp_path / "a.png").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_large_pictures_raise_no_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.BytesIO()
    Image.new("L", (40, 40)).save(stream, "jpeg")
    (tmp_path / "a.jpg").write_bytes(stream.getvalue())
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 1000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_image(tmp_path / "a.jpg").pixels.shape == (1, 40, 40)


def test_what_webp_cannot_hold_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a \.webp file can have at most 16383 pixels a side"):
        write_image(tmp_path / "long.webp", torch.zeros(3, 1, 16384), Kind("uint8", RGB))
    with pytest.raises(InputError, match="has an ending that cannot hold uint8 Y pixels"):
        write_image(tmp_path / "gray.webp", torch.zeros(1, 4, 4), Kind("uint8", GRAY))
