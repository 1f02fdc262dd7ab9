"""PNG, JPEG, TIFF and OpenEXR as arrays, and back, without loss.

`decode` gives the pixels as the file holds them, (H, W, C) in the file's own dtype, and a `Kind` that says what is
needed to write them again. What a file holds is told by its first bytes, not by its name. Pictures come upright: an
EXIF or TIFF orientation is applied, and written files carry none. Palettes and gray of 2 or 4 bits are expanded to
8 bits, CMYK to RGB; a color profile stays with the picture.
"""

import errno
import io
import logging
import os
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kwatra.base import InputError

Array = NDArray[Any]

_GRAY, _GRAY_ALPHA, _RGB, _RGBA = ("Y",), ("Y", "A"), ("R", "G", "B"), ("R", "G", "B", "A")
_USUAL = {1: _GRAY, 2: _GRAY_ALPHA, 3: _RGB, 4: _RGBA}
_ORIENTATION = 274  # the number of the tag in EXIF and TIFF


@dataclass(frozen=True)
class Kind:
    """How a file holds its pixels.

    dtype: numpy's name of the stored type; "bool" is one bit.
    channels: names in order: Y (gray), R, G, B, A (alpha), or what the file calls them.
    premultiplied: color was multiplied by alpha.
    profile: ICC color profile, empty where there is none.
    """

    dtype: str
    channels: tuple[str, ...]
    premultiplied: bool = False
    profile: bytes = field(default=b"", repr=False)

    def __str__(self) -> str:
        return f"{self.dtype} {''.join(self.channels) if max(map(len, self.channels)) == 1 else self.channels}"


def suffixes_for(kind: Kind) -> tuple[str, ...]:
    """The file name endings whose formats hold this kind without loss (for .jpg: but for its compression)."""
    endings = [".tif", ".tiff"]
    usual = kind.channels in _USUAL.values()
    if (usual and kind.dtype in ("uint8", "uint16")) or (kind.channels == _GRAY and kind.dtype == "bool"):
        endings.insert(0, ".png")
    if kind.channels in (_GRAY, _RGB) and kind.dtype == "uint8":
        endings += [".jpg", ".jpeg"]
    if kind.dtype in ("float16", "float32", "uint32"):
        endings.append(".exr")
    return tuple(endings)


def decode(path: Path) -> tuple[Array, Kind]:
    """Read the file at `path`: pixels (H, W, C) and their kind. Any failure but OSError is an InputError."""
    with path.open("rb") as file:
        head = file.read(8)
    if not head:
        raise InputError(f"{path} is empty; give a PNG, JPEG, TIFF or EXR file")
    reader = next((_READERS[start] for start in _READERS if head.startswith(start)), None)
    if reader is None:
        raise InputError(f"{path} is not a PNG, JPEG, TIFF or EXR image; convert it to one of these")
    try:
        return reader(path)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # each library has its own errors for broken files
        raise InputError(f"{path} is damaged or cut short ({_first_line(error)}); get it anew") from error


def encode(path: Path, pixels: Array, kind: Kind, suffix: str) -> None:
    """Write pixels (H, W, C), of the dtype and channels of `kind`, to `path` in the format that `suffix` names."""
    if suffix == ".exr":
        _write_exr(path, pixels, kind)
        return
    if suffix == ".png":
        data = _png_bytes(pixels, kind)
    elif suffix in (".jpg", ".jpeg"):
        data = _jpeg_bytes(pixels, kind)
    else:
        data = _tiff_bytes(pixels, kind)
    path.write_bytes(data)


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]


def _upright(pixels: Array, orientation: int) -> Array:
    """Turn (H, W, C) as the EXIF orientation 1..8 asks."""
    if orientation >= 5:
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)


# ---- PNG and JPEG: Pillow reads the header and JPEG; it would cut 16-bit color to 8 bits, so imagecodecs reads PNG


def _read_png(path: Path) -> tuple[Array, Kind]:
    import imagecodecs

    data = path.read_bytes()
    orientation, profile, _ = _header(path)
    bits, color = data[24], data[25]
    pixels = imagecodecs.png_decode(data)
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    if bits == 1 and color == 0 and pixels.shape[2] == 1:
        pixels = pixels > 0
    kind = Kind(pixels.dtype.name, _USUAL[pixels.shape[2]], profile=profile)
    return _upright(pixels, orientation), kind


def _read_jpeg(path: Path) -> tuple[Array, Kind]:
    from PIL import Image

    orientation, profile, mode = _header(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        with Image.open(path) as image:
            pixels = np.asarray(image if mode in ("L", "RGB") else image.convert("RGB"))
    if mode not in ("L", "RGB"):
        profile = b""  # it described the inks
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    return _upright(pixels, orientation), Kind("uint8", _USUAL[pixels.shape[2]], profile=profile)


def _header(path: Path) -> tuple[int, bytes, str]:
    """EXIF orientation, color profile and Pillow's mode."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        try:
            with Image.open(path) as image:
                orientation = image.getexif().get(_ORIENTATION, 1)
                return int(orientation), image.info.get("icc_profile") or b"", image.mode
        except Image.DecompressionBombError:
            raise InputError(f"{path} is larger than an exemplar can be; crop it") from None


def _png_bytes(pixels: Array, kind: Kind) -> bytes:
    import imagecodecs
    from PIL import Image

    if kind.dtype == "bool":
        stream = io.BytesIO()
        Image.fromarray(pixels[..., 0]).save(stream, "png", icc_profile=kind.profile or None)
        return stream.getvalue()
    data = bytes(imagecodecs.png_encode(np.ascontiguousarray(pixels)))
    if not kind.profile:
        return data
    body = b"iCCP" + b"profile\0\0" + zlib.compress(kind.profile)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    after_header = 33  # signature (8) and IHDR (25), which always comes first
    return data[:after_header] + chunk + data[after_header:]


def _jpeg_bytes(pixels: Array, kind: Kind) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    image = Image.fromarray(pixels if pixels.shape[2] > 1 else pixels[..., 0])
    image.save(stream, "jpeg", quality=95, subsampling=0, icc_profile=kind.profile or None)
    return stream.getvalue()


# ---- TIFF


def _read_tiff(path: Path) -> tuple[Array, Kind]:
    import tifffile

    logging.getLogger("tifffile").setLevel(logging.CRITICAL)  # it tells of damage there and raises as well
    with tifffile.TiffFile(path) as file:
        page, series = file.pages.first, file.series[0]
        axes = series.axes.replace("I", "Q")
        if axes.strip("S") != "YX" and max(series.shape[i] for i, a in enumerate(axes) if a not in "YXS") > 1:
            raise InputError(
                f"{path} holds several pages; save one as a file of its own (channels as samples of one page)"
            )
        pixels = page.asarray()
        if page.planarconfig == 2 and page.samplesperpixel > 1:
            pixels = np.moveaxis(pixels.reshape(-1, *pixels.shape[-2:]), 0, -1)
        pixels = pixels.reshape(page.imagelength, page.imagewidth, -1)
        pixels = pixels.astype(pixels.dtype.newbyteorder("="), copy=False)
        pixels, names = _tiff_colors(page, pixels)
        profile, tag = page.tags.get("InterColorProfile"), page.tags.get(_ORIENTATION)
        kind = Kind(
            pixels.dtype.name,
            names,
            premultiplied=1 in page.extrasamples,
            profile=bytes(profile.value) if profile is not None else b"",
        )
        return _upright(pixels, int(tag.value) if tag is not None else 1), kind


def _tiff_colors(page: Any, pixels: Array) -> tuple[Array, tuple[str, ...]]:
    """Pixels whose larger values are lighter, without a palette; names of the channels."""
    photometric = page.photometric.name
    if photometric == "PALETTE":
        pixels = (page.colormap.T[pixels[..., 0]] >> 8).astype(np.uint8)
        return pixels, _RGB
    if photometric == "MINISWHITE" and pixels.dtype.kind in "bu":
        pixels = ~pixels if pixels.dtype == bool else np.iinfo(pixels.dtype).max - pixels
    colors = _RGB if photometric in ("RGB", "YCBCR") and pixels.shape[2] >= 3 else _GRAY
    extras = [int(extra) for extra in page.extrasamples]
    extras += [0] * (pixels.shape[2] - len(colors) - len(extras))
    alpha = next((i for i, extra in enumerate(extras) if extra in (1, 2)), None)
    return pixels, (*colors, *("A" if i == alpha else f"X{i + 1}" for i in range(len(extras))))


def _tiff_bytes(pixels: Array, kind: Kind) -> bytes:
    import tifffile

    colors = 3 if kind.channels[:3] == _RGB else 1
    alpha = "assocalpha" if kind.premultiplied else "unassalpha"
    stream = io.BytesIO()
    tifffile.imwrite(
        stream,
        pixels if pixels.shape[2] > 1 else pixels[..., 0],
        photometric="rgb" if colors == 3 else "minisblack",
        planarconfig="contig" if pixels.shape[2] > 1 else None,
        extrasamples=[alpha if name == "A" else "unspecified" for name in kind.channels[colors:]],
        compression=None if kind.dtype == "bool" else "zlib",
        predictor=kind.dtype in ("uint8", "uint16"),
        iccprofile=kind.profile or None,
        metadata=None,
        bigtiff=pixels.nbytes > 2**31,
    )
    return stream.getvalue()


# ---- OpenEXR


def _read_exr(path: Path) -> tuple[Array, Kind]:
    import OpenEXR

    with _quiet(), OpenEXR.File(str(path), separate_channels=True) as file:
        if len(file.parts) > 1:
            raise InputError(f"{path} has {len(file.parts)} parts; save one as a file of its own")
        channels = file.channels()
        names = tuple(sorted(channels, key=_exr_order))
        planes = [np.array(channels[name].pixels) for name in names]
    if len({plane.shape for plane in planes}) > 1:
        raise InputError(f"{path} has channels of different sizes; save it without subsampling")
    pixels = np.stack([plane.astype(np.result_type(*planes), copy=False) for plane in planes], -1)
    return pixels, Kind(pixels.dtype.name, names, premultiplied="A" in names)


def _exr_order(name: str) -> tuple[str, int, str]:
    layer, _, channel = name.rpartition(".")
    return layer, {"R": 0, "G": 1, "B": 2, "A": 4}.get(channel, 3), channel


def _write_exr(path: Path, pixels: Array, kind: Kind) -> None:
    import OpenEXR

    planes = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate(kind.channels)}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with _quiet():
        try:
            with OpenEXR.File(header, planes) as file:
                file.write(str(path))
            _read_exr(path)
        except Exception as error:  # the library does not notice a full disk; reading back does
            raise OSError(errno.EIO, "it came out incomplete; is the disk full?") from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence OpenEXR, which prints on both outputs, on stderr from native code, what it also raises."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        with redirect_stdout(io.StringIO()):
            yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


_READERS = {
    b"\x89PNG\r\n\x1a\n": _read_png,
    b"\xff\xd8\xff": _read_jpeg,
    b"II*\0": _read_tiff,
    b"MM\0*": _read_tiff,
    b"II+\0": _read_tiff,
    b"MM\0+": _read_tiff,
    b"\x76\x2f\x31\x01": _read_exr,
}
