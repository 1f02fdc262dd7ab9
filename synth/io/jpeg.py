"""JPEG as arrays, and back, by Pillow. CMYK becomes RGB."""

import io
from pathlib import Path

import numpy as np

from synth.io.kinds import ORIENTATION, USUAL, Array, Kind, check_extent, upright


def read_jpeg(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    from PIL.JpegImagePlugin import JpegImageFile

    with JpegImageFile(path) as image:
        check_extent(path, image.width, image.height, len(image.getbands()))
        orientation, profile = int(image.getexif().get(ORIENTATION, 1)), image.info.get("icc_profile") or b""
        if image.mode not in ("L", "RGB"):
            profile = b""  # it described the inks
        pixels = np.array(image if image.mode in ("L", "RGB") else image.convert("RGB"))
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    return upright(pixels, orientation), Kind("uint8", USUAL[pixels.shape[2]], profile=profile)


def jpeg_bytes(pixels: Array, kind: Kind) -> bytes:
    """A JPEG file's bytes, at high quality and with colors of full resolution."""
    from PIL import Image

    stream = io.BytesIO()
    image = Image.fromarray(pixels if pixels.shape[2] > 1 else pixels[..., 0])
    image.save(stream, "jpeg", quality=95, subsampling=0, icc_profile=kind.profile or None)
    return stream.getvalue()
