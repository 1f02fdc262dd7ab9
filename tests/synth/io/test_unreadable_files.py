"""Image files that cannot be read say so in one sentence."""

import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from arrays import GRAY, RGB, some_array
from PIL import Image

from kwatra import InputError
from synth import Kind, read_image, write_image
from synth.io.images import read_values


def damaged(path: Path, keep: float = 0.6) -> Path:
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep)])
    return path


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.png does not exist; check"):
        read_image(tmp_path / "none.png")


def test_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder; name an image file"):
        read_image(tmp_path)


def test_empty_file(tmp_path: Path) -> None:
    (tmp_path / "empty.png").touch()
    with pytest.raises(InputError, match=r"empty\.png is empty; give"):
        read_image(tmp_path / "empty.png")


def test_not_an_image(tmp_path: Path) -> None:
    (tmp_path / "words.png").write_text("not an image at all")
    with pytest.raises(InputError, match=r"words\.png is not a PNG, JPEG, TIFF, EXR, WebP, BMP or TGA image; convert"):
        read_image(tmp_path / "words.png")


@pytest.mark.parametrize("keep", [0.05, 0.3, 0.9])
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".exr"])
def test_truncated_file(tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str, keep: float) -> None:
    kind = Kind("float32" if suffix == ".exr" else "uint8", RGB)
    path = tmp_path / f"cut{suffix}"
    write_image(path, torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0)), kind)
    with pytest.raises(InputError, match=r"cut\.\w+ is damaged or cut short .*; get it anew"):
        read_image(damaged(path, keep))
    assert capfd.readouterr() == ("", "")


def test_changed_bytes_in_a_png(tmp_path: Path) -> None:
    path = tmp_path / "bits.png"
    write_image(path, torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0)), Kind("uint8", RGB))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 255
    path.write_bytes(data)
    with pytest.raises(InputError, match="is damaged"):
        read_image(path)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_pixels_that_are_not_finite(tmp_path: Path, bad: float) -> None:
    array = some_array("float32", 3)
    array[2, 3] = bad
    tifffile.imwrite(tmp_path / "bad.tif", array, photometric="rgb")
    with pytest.raises(InputError, match=r"bad\.tif has 3 values not finite, NaN or infinite; replace"):
        read_image(tmp_path / "bad.tif")


def test_several_pages(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "pages.tif", np.zeros((5, 20, 20), np.float32))
    with pytest.raises(InputError, match=r"pages\.tif holds several pages; save one"):
        read_image(tmp_path / "pages.tif")


def test_whole_numbers_of_other_widths(tmp_path: Path) -> None:
    tifffile.imwrite(tmp_path / "ids.tif", np.arange(64, dtype=np.uint32).reshape(8, 8))
    with pytest.raises(InputError, match="holds uint32 pixels; save it with 8 or 16 bits or as float"):
        read_image(tmp_path / "ids.tif")
    assert read_values(tmp_path / "ids.tif")[1].dtype == "uint32"


def png_of(width: int, height: int) -> bytes:
    """A PNG whose head says that size, with hardly any pixels in it."""
    stream = io.BytesIO()
    Image.new("L", (1, 1)).save(stream, "png")
    head = b"IHDR" + struct.pack(">II", width, height) + stream.getvalue()[24:29]
    return stream.getvalue()[:12] + head + struct.pack(">I", zlib.crc32(head)) + stream.getvalue()[33:]


def tiff_of(width: int, height: int) -> bytes:
    """A TIFF whose tags say that size, with hardly any pixels in it."""
    stream = io.BytesIO()
    tifffile.imwrite(stream, np.zeros((777, 333), np.uint8), metadata=None)
    data = stream.getvalue()
    for tag, old, new in ((256, 333, width), (257, 777, height)):
        for kind in (3, 4):  # SHORT, LONG
            old_bytes = struct.pack("<HHII", tag, kind, 1, old)
            data = data.replace(old_bytes, struct.pack("<HHII", tag, 4, 1, new))
    return data


@pytest.mark.parametrize(("name", "made"), [("large.png", png_of), ("large.tif", tiff_of)])
def test_one_limit_for_all_formats_is_seen_before_pixels_are_read(
    tmp_path: Path, name: str, made: Callable[[int, int], bytes]
) -> None:
    (tmp_path / name).write_bytes(made(20000, 20000))
    with pytest.raises(InputError, match=f"{name} is 20000x20000 with 1 channel; an image may have 2\\^28 pixels"):
        read_image(tmp_path / name)


@pytest.mark.parametrize("suffix", [".jpg", ".exr"])
def test_the_limit_holds_for_what_must_be_whole_to_have_a_head(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    kind = Kind("uint8" if suffix == ".jpg" else "float32", GRAY)
    write_image(tmp_path / f"large{suffix}", torch.zeros(1, 64, 64), kind)
    monkeypatch.setattr("synth.io.kinds.MOST_PIXELS", 1000)
    with pytest.raises(InputError, match="is 64x64 with 1 channel; an image may have"):
        read_image(tmp_path / f"large{suffix}")


def test_animated_and_damaged_files_are_refused(tmp_path: Path) -> None:
    frames = [Image.fromarray(some_array("uint8", 3, seed)) for seed in range(2)]
    for suffix in (".webp", ".png"):
        frames[0].save(tmp_path / f"two{suffix}", save_all=True, append_images=frames[1:])
        with pytest.raises(InputError, match=rf"two\{suffix} holds several frames"):
            read_image(tmp_path / f"two{suffix}")
    for suffix in (".webp", ".bmp", ".tga"):
        frames[0].save(tmp_path / f"whole{suffix}")
        data = (tmp_path / f"whole{suffix}").read_bytes()
        (tmp_path / f"cut{suffix}").write_bytes(data[:40])
        with pytest.raises(InputError, match=rf"cut\{suffix} is damaged or cut short"):
            read_image(tmp_path / f"cut{suffix}")
