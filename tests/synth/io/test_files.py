"""Files come back exactly as they went in; what cannot be read or written says so in one sentence."""

import errno
import io
import os
import struct
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from PIL import Image, ImageCms

from kwatra import InputError
from synth import Kind, read_image, write_image
from synth.io.images import read_array, read_values, write_files

GRAY, GRAY_ALPHA, RGB, RGBA = ("Y",), ("Y", "A"), ("R", "G", "B"), ("R", "G", "B", "A")
SHAPE = (11, 14)

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


def some_array(dtype: str, channels: int, seed: int = 0) -> np.ndarray:
    generator = np.random.default_rng(seed)
    shape = (*SHAPE, channels)
    if dtype == "bool":
        return generator.random(shape) > 0.5
    if dtype.startswith("u"):
        return generator.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    return (generator.standard_normal(shape) * 3).astype(np.float32).astype(dtype)


def as_pixels(array: np.ndarray) -> torch.Tensor:
    scale = np.iinfo(array.dtype).max if array.dtype.kind == "u" else 1
    return torch.from_numpy(array.transpose(2, 0, 1).astype(np.float32) / np.float32(scale))


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


@pytest.mark.parametrize("orientation", range(1, 9))
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


# ---- what cannot be read


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


# ---- what cannot be written


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
        write_files({target: lambda _: write(Path("/dev/full"))})
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


def test_an_animated_webp_and_damaged_files_are_refused(tmp_path: Path) -> None:
    frames = [Image.fromarray(some_array("uint8", 3, seed)) for seed in range(2)]
    frames[0].save(tmp_path / "two.webp", save_all=True, append_images=frames[1:])
    with pytest.raises(InputError, match=r"two\.webp holds several frames"):
        read_image(tmp_path / "two.webp")
    for suffix in (".webp", ".bmp", ".tga"):
        frames[0].save(tmp_path / f"whole{suffix}")
        data = (tmp_path / f"whole{suffix}").read_bytes()
        (tmp_path / f"cut{suffix}").write_bytes(data[:40])
        with pytest.raises(InputError, match=rf"cut\{suffix} is damaged or cut short"):
            read_image(tmp_path / f"cut{suffix}")


def test_what_webp_cannot_hold_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a \.webp file can have at most 16383 pixels a side"):
        write_image(tmp_path / "long.webp", torch.zeros(3, 1, 16384), Kind("uint8", RGB))
    with pytest.raises(InputError, match="has an ending that cannot hold uint8 Y pixels"):
        write_image(tmp_path / "gray.webp", torch.zeros(1, 4, 4), Kind("uint8", GRAY))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp", ".bmp", ".tga"])
def test_pixels_that_were_read_may_be_changed(tmp_path: Path, suffix: str) -> None:
    write_image(tmp_path / f"a{suffix}", torch.zeros(3, 8, 8), Kind("uint8", RGB))
    assert read_array(tmp_path / f"a{suffix}")[0].flags.writeable
