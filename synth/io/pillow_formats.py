"""WebP, BMP and TGA as arrays, and back without loss, by Pillow. Palettes become color; only WebP keeps a profile."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import ORIENTATION, USUAL, Array, Kind, check_extent, upright

_CHANNELS = {"1": 1, "L": 1, "LA": 2, "RGB": 3, "RGBA": 4}
_MOST_SIDE = {".webp": 2**14 - 1, ".tga": 2**16 - 1}


def read_webp(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind; the file's own are always color."""
    from PIL.WebPImagePlugin import WebPImageFile

    return _read(path, WebPImageFile)


def read_bmp(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    from PIL.BmpImagePlugin import BmpImageFile

    return _read(path, BmpImageFile)


def read_tga(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    from PIL.TgaImagePlugin import TgaImageFile

    return _read(path, TgaImageFile)


def webp_bytes(pixels: Array, kind: Kind) -> bytes:
    """A WebP file's bytes, without loss, also of colors that alpha hides."""
    return _bytes(pixels, ".webp", lossless=True, exact=True, icc_profile=kind.profile or b"")


def bmp_bytes(pixels: Array, kind: Kind) -> bytes:
    """A BMP file's bytes."""
    return _bytes(pixels, ".bmp")


def tga_bytes(pixels: Array, kind: Kind) -> bytes:
    """A TGA file's bytes, run-length encoded."""
    return _bytes(pixels, ".tga", compression="tga_rle")


def _read(path: Path, opened: Any) -> tuple[Array, Kind]:
    with opened(path) as image:
        if getattr(image, "n_frames", 1) > 1:
            raise InputError(f"{path} holds several frames; save one as a file of its own")
        check_extent(path, image.width, image.height, len(image.getbands()))
        orientation, profile = int(image.getexif().get(ORIENTATION, 1)), image.info.get("icc_profile") or b""
        clear = image.mode == "PA" or "transparency" in image.info
        plain = image if image.mode in _CHANNELS else image.convert("RGBA" if clear else "RGB")
        pixels = np.array(plain).reshape(plain.height, plain.width, -1)
    return upright(pixels, orientation), Kind(pixels.dtype.name, USUAL[pixels.shape[2]], profile=profile)


def _bytes(pixels: Array, suffix: str, **options: Any) -> bytes:
    from PIL import Image

    most = _MOST_SIDE.get(suffix, 2**31)
    if max(pixels.shape[:2]) > most:
        raise InputError(f"a {suffix} file can have at most {most} pixels a side; end the name with .png")
    stream = io.BytesIO()
    image = Image.fromarray(np.ascontiguousarray(pixels if pixels.shape[2] > 1 else pixels[..., 0]))
    image.save(stream, suffix[1:], **options)
    return stream.getvalue()
