"""PNG, JPEG, TIFF, OpenEXR, WebP, BMP and TGA as arrays, and back, without loss.

`decode` gives the pixels as the file holds them, (H, W, C) in the file's own dtype, and a `Kind` that says what is
needed to write them again. What a file holds is told by its first bytes, not by its name; only TGA has none. Pictures
come upright: an EXIF or TIFF orientation is applied, and written files carry none. Palettes and gray of 2 or 4 bits are
expanded to 8 bits, the inks of a JPEG to RGB; a color profile stays with the picture where the format has one.
"""

from pathlib import Path

from kwatra.base import InputError
from synth.io.exr import read_exr, write_exr
from synth.io.jpeg import jpeg_bytes, read_jpeg
from synth.io.kinds import Array, Kind
from synth.io.pillow_formats import bmp_bytes, read_bmp, read_tga, read_webp, tga_bytes, webp_bytes
from synth.io.png import png_bytes, read_png
from synth.io.streams import STREAM, standard_input
from synth.io.tiff import read_tiff, tiff_bytes

_READERS = {
    b"\x89PNG\r\n\x1a\n": read_png,
    b"\xff\xd8\xff": read_jpeg,
    b"II*\0": read_tiff,
    b"MM\0*": read_tiff,
    b"II+\0": read_tiff,
    b"MM\0+": read_tiff,
    b"\x76\x2f\x31\x01": read_exr,
    b"BM": read_bmp,
}

_ENCODERS = {
    ".png": png_bytes,
    ".jpg": jpeg_bytes,
    ".jpeg": jpeg_bytes,
    ".tif": tiff_bytes,
    ".tiff": tiff_bytes,
    ".webp": webp_bytes,
    ".bmp": bmp_bytes,
    ".tga": tga_bytes,
}
_ALL = "PNG, JPEG, TIFF, EXR, WebP, BMP or TGA"


def decode(path: Path) -> tuple[Array, Kind]:
    """Read the file at `path`, or standard input for `-`: pixels (H, W, C) and their kind.

    Any failure but OSError is an InputError.
    """
    name: object = path
    if path == STREAM:
        path, name = standard_input(), "standard input"
    with path.open("rb") as file:
        head = file.read(12)
    if not head:
        raise InputError(f"{name} is empty; give a {_ALL} file")
    reader = next((_READERS[start] for start in _READERS if head.startswith(start)), None)
    if head.startswith(b"RIFF") and head.endswith(b"WEBP"):
        reader = read_webp
    if reader is None and path.suffix.lower() == ".tga":
        reader = read_tga
    if reader is None:
        raise InputError(f"{name} is not a {_ALL} image; convert it to one of these")
    try:
        return reader(path)
    except (InputError, MemoryError, ImportError):
        raise
    except Exception as error:  # each library has its own errors for broken files
        raise InputError(f"{name} is damaged or cut short ({_first_line(error)}); get it anew") from error


def encode(path: Path, pixels: Array, kind: Kind, suffix: str) -> None:
    """Write pixels (H, W, C), of the dtype and channels of `kind`, to `path` in the format that `suffix` names."""
    if suffix == ".exr":
        write_exr(path, pixels, kind)
    else:
        path.write_bytes(_ENCODERS[suffix](pixels, kind))


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
