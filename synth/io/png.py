"""PNG as arrays, and back. Pillow would cut 16-bit color to 8 bits, so imagecodecs reads and writes the pixels."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import GRAY, ORIENTATION, USUAL, Array, Kind, check_extent, upright
from synth.io.quiet import quiet


def read_png(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    from PIL.PngImagePlugin import PngImageFile

    data = path.read_bytes()
    pixels = png_pixels(path, data)
    if data[24:26] == b"\1\0" and pixels.shape[2] == 1:
        pixels = pixels > 0
    with PngImageFile(path) as head:
        if getattr(head, "n_frames", 1) > 1:
            raise InputError(f"{path} holds several frames; save one as a file of its own")
        orientation, profile = int(head.getexif().get(ORIENTATION, 1)), head.info.get("icc_profile") or b""
    return upright(pixels, orientation), Kind(pixels.dtype.name, USUAL[pixels.shape[2]], profile=profile)


def png_pixels(path: Path, data: bytes) -> Array:
    """The pixels (H, W, C) of a PNG file's bytes, palettes and gray of 2 or 4 bits as 8 bits."""
    import imagecodecs

    width, height, _, color = struct.unpack(">IIBB", data[16:26])
    check_extent(path, width, height, {2: 3, 3: 4, 4: 2, 6: 4}.get(color, 1))

    with quiet():
        pixels = imagecodecs.png_decode(data)
    return pixels.reshape(*pixels.shape[:2], -1)


def png_bytes(pixels: Array, kind: Kind) -> bytes:
    """A PNG file's bytes."""
    if kind.dtype == "bool":
        return _bits(pixels, kind)
    import imagecodecs

    data = bytes(imagecodecs.png_encode(np.ascontiguousarray(pixels)))
    if not kind.profile:
        return data
    body = b"iCCP" + b"profile\0\0" + zlib.compress(kind.profile)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    after_header = 33  # signature (8) and IHDR (25), which always comes first
    return data[:after_header] + chunk + data[after_header:]


def _bits(pixels: Array, kind: Kind) -> bytes:
    from PIL import Image

    assert kind.channels == GRAY
    stream = io.BytesIO()
    Image.fromarray(pixels[..., 0]).save(stream, "png", icc_profile=kind.profile or None)
    return stream.getvalue()
