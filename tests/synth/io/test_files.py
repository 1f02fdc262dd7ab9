"""Files come back exactly as they went in."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from arrays import GRAY, GRAY_ALPHA, RGB, RGBA, SHAPE, as_pixels, some_array
from PIL import Image, ImageCms

from synth import Kind, read_image, write_image
from synth.io.images import read_array

CASES = [
    (".png", "bool", GRAY),
    *[(".png", dtype, channels) for dtype in ("uint8", "uint16") for channels in (GRAY, GRAY_ALPHA, RGB, RGBA)],
    *[
        (".tif", dtype, channels)
        for dtype in ("uint8", "uint16", "float16", "float32", "float64")
        for channels in (GRAY, GRAY_ALPHA, RGB, RGBA)
    ],
    *[(".webp", "uint8", channels) for channels in (RGB, RGBA)],
    *[(".bmp", "uint8", channels) for channels in (GRAY, RGB)],
    *[(".tga", "uint8", channels) for channels in (GRAY, GRAY_ALPHA, RGB, RGBA)],
    (".tif", "bool", GRAY),
    (".tiff", "float32", ("Y", "X1", "X2", "X3", "X4")),
    (".tif", "uint16", ("R", "G", "B", "X1", "A")),
    *[
        (".exr", dtype, channels)
        for dtype in ("float16", "float32")
        for channels in (GRAY, GRAY_ALPHA, RGB, RGBA, ("Z",), ("R", "G", "B", "N.X", "N.Y", "N.Z"))
    ],
]


@pytest.mark.parametrize(("suffix", "dtype", "channels"), CASES)
def test_round_trip_is_exact(tmp_path: Path, suffix: str, dtype: str, channels: tuple[str, ...]) -> None:
    array = some_array(dtype, len(channels))
    kind = Kind(dtype, channels, premultiplied=suffix == ".exr" and "A" in channels)
    path = tmp_path / f"image{suffix}"
    write_image(path, as_pixels(array), kind)
    stored, stored_kind = read_array(path)
    assert stored_kind == kind
    np.testing.assert_array_equal(stored, array)
    picture = read_image(path)
    assert picture.pixels.dtype == torch.float32
    assert torch.equal(picture.pixels, as_pixels(array))
    again = tmp_path / f"again{suffix}"
    write_image(again, picture.pixels, picture.kind)
    np.testing.assert_array_equal(read_array(again)[0], array)
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"again{suffix}", f"image{suffix}"]


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_every_integer_value_survives(tmp_path: Path, dtype: str) -> None:
    array = np.arange(np.iinfo(dtype).max + 1, dtype=dtype).reshape(-1, 64, 1)
    write_image(tmp_path / "all.png", as_pixels(array), Kind(dtype, GRAY))
    np.testing.assert_array_equal(read_array(tmp_path / "all.png")[0], array)


@pytest.mark.parametrize("channels", [GRAY, RGB])
def test_jpeg_keeps_kind(tmp_path: Path, channels: tuple[str, ...]) -> None:
    pixels = torch.full((len(channels), *SHAPE), 0.4)
    write_image(tmp_path / "flat.jpg", pixels, Kind("uint8", channels))
    picture = read_image(tmp_path / "flat.jpg")
    assert picture.kind == Kind("uint8", channels)
    assert torch.allclose(picture.pixels, pixels, atol=0.01)


def test_another_program_reads_what_is_written(tmp_path: Path) -> None:
    array = some_array("uint8", 4)
    for suffix in (".png", ".tif"):
        write_image(tmp_path / f"image{suffix}", as_pixels(array), Kind("uint8", RGBA))
        with Image.open(tmp_path / f"image{suffix}") as image:
            assert image.mode == "RGBA"
            np.testing.assert_array_equal(np.asarray(image), array)


def test_palette_is_expanded(tmp_path: Path) -> None:
    image = Image.fromarray(some_array("uint8", 3)).quantize(16)
    image.save(tmp_path / "palette.png")
    image.save(tmp_path / "palette.tif")
    image.save(tmp_path / "clear.png", transparency=0)
    for name in ("palette.png", "palette.tif"):
        array, kind = read_array(tmp_path / name)
        assert kind == Kind("uint8", RGB)
        np.testing.assert_array_equal(array, np.asarray(image.convert("RGB")))
    assert read_array(tmp_path / "clear.png")[1] == Kind("uint8", RGBA)


def test_gray_of_two_bits_is_expanded(tmp_path: Path) -> None:
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 1, 2, 0, 0, 0, 0))
    data = chunk(b"IDAT", zlib.compress(bytes([0, 0b00011011])))
    (tmp_path / "two.png").write_bytes(b"\x89PNG\r\n\x1a\n" + header + data + chunk(b"IEND", b""))
    array, kind = read_array(tmp_path / "two.png")
    assert kind == Kind("uint8", GRAY)
    assert array.ravel().tolist() == [0, 85, 170, 255]


def test_cmyk_becomes_rgb(tmp_path: Path) -> None:
    Image.fromarray(some_array("uint8", 4), "CMYK").save(tmp_path / "inks.jpg")
    assert read_image(tmp_path / "inks.jpg").kind == Kind("uint8", RGB)


@pytest.mark.parametrize("orientation", [*range(1, 9), 99])
@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_orientation_is_applied(tmp_path: Path, suffix: str, orientation: int) -> None:
    from PIL import ImageOps

    path = tmp_path / f"turned{suffix}"
    image = Image.fromarray(some_array("uint8", 3))
    exif = image.getexif()
    exif[274] = orientation
    image.save(path, exif=exif) if suffix == ".png" else image.save(path, tiffinfo={274: orientation})
    with Image.open(path) as stored:
        upright = np.asarray(ImageOps.exif_transpose(stored))
    np.testing.assert_array_equal(read_array(path)[0], upright)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_color_profile_stays(tmp_path: Path, suffix: str) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Image.fromarray(some_array("uint8", 3)).save(tmp_path / f"in{suffix}", icc_profile=profile)
    picture = read_image(tmp_path / f"in{suffix}")
    write_image(tmp_path / f"out{suffix}", picture.pixels, picture.kind)
    with Image.open(tmp_path / f"out{suffix}") as image:
        assert image.info["icc_profile"] == profile


@pytest.mark.parametrize(
    "options",
    [
        {"compression": "lzw"},
        {"compression": "zlib", "predictor": True},
        {"photometric": "miniswhite"},
        {"byteorder": ">"},
        {"bigtiff": True},
    ],
)
def test_tiff_variants(tmp_path: Path, options: dict) -> None:
    array = some_array("uint16", 1)
    stored = 65535 - array if options.get("photometric") == "miniswhite" else array
    tifffile.imwrite(tmp_path / "image.tif", stored[..., 0], **options)
    np.testing.assert_array_equal(read_array(tmp_path / "image.tif")[0], array)


def test_tiff_planes(tmp_path: Path) -> None:
    array = some_array("uint8", 3)
    planes = np.moveaxis(array, -1, 0)
    tifffile.imwrite(tmp_path / "planes.tif", planes, photometric="rgb", planarconfig="separate")
    np.testing.assert_array_equal(read_array(tmp_path / "planes.tif")[0], array)


def test_values_outside_the_range_are_clipped_only_in_integers(tmp_path: Path) -> None:
    pixels = torch.tensor([-0.5, 0.5, 1.5]).view(1, 1, 3)
    write_image(tmp_path / "a.png", pixels, Kind("uint8", GRAY))
    write_image(tmp_path / "a.exr", pixels, Kind("float32", GRAY))
    assert read_array(tmp_path / "a.png")[0].ravel().tolist() == [0, 128, 255]
    assert torch.equal(read_image(tmp_path / "a.exr").pixels, pixels)


def test_a_color_profile_and_an_orientation_in_webp(tmp_path: Path) -> None:
    array = some_array("uint8", 3)
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    write_image(tmp_path / "a.webp", as_pixels(array), Kind("uint8", RGB, profile=profile))
    assert read_array(tmp_path / "a.webp")[1].profile == profile
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(array).save(tmp_path / "turned.webp", lossless=True, exif=exif)
    np.testing.assert_array_equal(read_array(tmp_path / "turned.webp")[0], np.rot90(array, -1))


def test_palettes_of_bmp_and_tga_become_color(tmp_path: Path) -> None:
    picture = Image.fromarray(some_array("uint8", 3)).quantize(16)
    for suffix in (".bmp", ".tga"):
        picture.save(tmp_path / f"a{suffix}")
        stored, kind = read_array(tmp_path / f"a{suffix}")
        assert kind == Kind("uint8", RGB)
        np.testing.assert_array_equal(stored, np.asarray(picture.convert("RGB")))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp", ".bmp", ".tga"])
def test_pixels_that_were_read_may_be_changed(tmp_path: Path, suffix: str) -> None:
    write_image(tmp_path / f"a{suffix}", torch.zeros(3, 8, 8), Kind("uint8", RGB))
    assert read_array(tmp_path / f"a{suffix}")[0].flags.writeable
