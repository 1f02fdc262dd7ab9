"""What a file's pixels are, how many of them there may be, and which formats hold them."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kwatra.base import InputError
from synth.words import counted

Array = NDArray[Any]

GRAY, GRAY_ALPHA, RGB, RGBA = ("Y",), ("Y", "A"), ("R", "G", "B"), ("R", "G", "B", "A")
USUAL = {1: GRAY, 2: GRAY_ALPHA, 3: RGB, 4: RGBA}
"""The channels of a file that names none, by their number."""

ORIENTATION = 274
"""The number of the tag in EXIF and TIFF."""

MOST_PIXELS, MOST_VALUES = 2**28, 2**30
"""What an image file may hold, in any format: pixels, and values in all its channels."""


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

    @property
    def bytes_per_pixel(self) -> int:
        """Of what is stored, before it is compressed."""
        return np.dtype(self.dtype).itemsize * len(self.channels)


def check_extent(path: Path, width: int, height: int, channels: int) -> None:
    """Refuse, by a file's head and before its pixels are read, an image larger than any that is read."""
    if min(width, height, channels) < 1:
        raise InputError(f"{path} says that it is {width}x{height} with {counted(channels, 'channel')}; get it anew")
    if width * height > MOST_PIXELS or width * height * channels > MOST_VALUES:
        raise InputError(
            f"{path} is {width}x{height} with {counted(channels, 'channel')}; an image may have 2^28 pixels "
            "and 2^30 values in all its channels, so crop it"
        )


def suffixes_for(kind: Kind) -> tuple[str, ...]:
    """The file name endings whose formats hold this kind without loss (for .jpg: but for its compression)."""
    endings = [".tif", ".tiff"]
    usual = kind.channels in USUAL.values()
    if (usual and kind.dtype in ("uint8", "uint16")) or (kind.channels == GRAY and kind.dtype == "bool"):
        endings.insert(0, ".png")
    if kind.channels in (GRAY, RGB) and kind.dtype == "uint8":
        endings += [".jpg", ".jpeg"]
    if usual and kind.dtype == "uint8":
        endings += [".webp"] if kind.channels[:3] == RGB else []
        endings += [".bmp"] if "A" not in kind.channels else []
        endings.append(".tga")
    if kind.dtype in ("float16", "float32", "uint32"):
        endings.append(".exr")
    return tuple(endings)


def frame_ending(kind: Kind) -> str:
    """The ending of the files of a folder of frames of this kind."""
    return ".png" if ".png" in suffixes_for(kind) else ".tif"


def upright(pixels: Array, orientation: int) -> Array:
    """Turn (H, W, C) as the EXIF orientation 1..8 asks; another number asks for nothing."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)
