"""Images in and out of files: read with their kind, written whole or not at all.

Integer pixels become [0, 1] and come back exactly; float pixels keep their values, whatever their range.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError
from synth.io.image_formats import decode, encode
from synth.io.kinds import Array, Kind, suffixes_for
from synth.io.outputs import Writer, check_writable, write_files
from synth.io.streams import STREAM, check_standard_output
from synth.io.unreadable import reading
from synth.words import counted

_DTYPES = ("bool", "uint8", "uint16", "float16", "float32", "float64")

LARGEST = 1e18
"""What a pixel's value may be: its square is still a float."""


@dataclass(frozen=True)
class Picture:
    """An image file's content: pixels (C, H, W) float32 and the kind of file they came from.

    Pixels are in [0, 1] where the file holds integers, else the file's own values.
    """

    pixels: Tensor
    kind: Kind


def read_image(path: str | Path) -> Picture:
    """Read a PNG, JPEG, TIFF, EXR, WebP, BMP or TGA file.

    Raises InputError when the file is missing, is no such image, is damaged, or too large, holds numbers of other types
    than 8 or 16 bits and floats, or pixels that are NaN, infinite, or beyond 1e18.
    """
    array, kind = read_array(path)
    return Picture(to_pixels(array), kind)


def read_array(path: str | Path) -> tuple[Array, Kind]:
    """The pixels (H, W, C) as the file holds them, and their kind. Raises as `read_image` does."""
    array, kind = read_values(path)
    if kind.dtype not in _DTYPES:
        raise InputError(f"{path} holds {kind.dtype} pixels; save it with 8 or 16 bits or as float")
    if array.dtype.kind == "f" and array.size and float(np.abs(array).max()) > LARGEST:
        raise InputError(f"{path} has values beyond {LARGEST:g}; scale them down")
    return array, kind


def read_values(path: str | Path) -> tuple[Array, Kind]:
    """The values (H, W, C) of a map that is looked up and never mixed, of any type but finite. Raises so, too."""
    path = Path(path)
    with reading(path, "an image file"):
        array, kind = decode(path)
    bad = array.size - int(np.isfinite(array).sum()) if array.dtype.kind == "f" else 0
    if bad:
        raise InputError(f"{path} has {counted(bad, 'value')} not finite, NaN or infinite; replace them")
    return array, kind


def write_image(path: str | Path, pixels: Tensor, kind: Kind, overwrite: bool = False) -> None:
    """Write pixels (C, H, W) as a file of this kind; the ending of `path` names the format.

    Raises InputError when the format cannot hold the kind, the file exists and `overwrite` is not set, its folder
    does not exist, or it cannot be written; then no file is left and an existing one is as it was.
    """
    check_output(path, kind, overwrite)
    write_files({Path(path): image_writer(path, pixels, kind)}, overwrite)


def read_mask(path: str | Path) -> Tensor:
    """Read an image as booleans (H, W): white is True, or opaque where it has alpha; of "not:FILE" the opposite.

    Raises as `read_image` does.
    """
    if str(path).startswith("not:"):
        return ~read_mask(str(path).removeprefix("not:"))
    picture = read_image(path)
    if picture.kind.channels[-1] == "A" and bool((picture.pixels[-1] < 1).any()):
        return picture.pixels[-1] > 0.5
    colors = picture.pixels[:-1] if picture.kind.channels[-1] == "A" else picture.pixels
    return colors.mean(0) > 0.5


def image_writer(path: str | Path, pixels: Tensor, kind: Kind) -> Writer:
    """What writes pixels (C, H, W) in the format that the ending of `path` names; see `write_files`."""
    return array_writer(path, from_pixels(pixels, kind), kind)


def array_writer(path: str | Path, array: Array, kind: Kind) -> Writer:
    """What writes an array (H, W, C) that already has the kind's dtype; see `write_files`.

    To standard output, `-`, as PNG, or TIFF where that cannot hold the kind.
    """
    suffix = suffixes_for(kind)[0] if Path(path) == STREAM else Path(path).suffix.lower()
    return lambda target: encode(target, array, kind, suffix)


def check_output(path: str | Path, kind: Kind | None, overwrite: bool, suffixes: Iterable[str] = ()) -> None:
    """Refuse, before any work, a file that could not be written; an image's may be `-`, standard output.

    The ending must be one that can hold `kind`, or where that is None one of `suffixes`.
    """
    path = Path(path)
    if path == STREAM and kind is not None:
        check_standard_output()
        return
    allowed = tuple(suffixes) if kind is None else suffixes_for(kind)
    if path.suffix.lower() not in allowed:
        what = "it" if kind is None else f"{kind} pixels"
        raise InputError(f"{path} has an ending that cannot hold {what}; end it with {' or '.join(allowed)}")
    check_writable(path, overwrite)


def to_pixels(array: Array) -> Tensor:
    """Values (H, W, C) as a file holds them as pixels (C, H, W): integers in [0, 1], floats as they are."""
    values = array.astype(np.float32)
    if array.dtype.kind == "u":
        values /= np.iinfo(array.dtype).max
    return torch.from_numpy(np.ascontiguousarray(values.transpose(2, 0, 1)))


def from_pixels(pixels: Tensor, kind: Kind) -> Array:
    """The inverse of `to_pixels`."""
    if pixels.ndim != 3 or pixels.shape[0] != len(kind.channels):
        raise InputError(
            f"pixels have shape {tuple(pixels.shape)}; give (C, H, W) with {len(kind.channels)} channels for {kind}"
        )
    values = np.ascontiguousarray(pixels.detach().cpu().numpy().transpose(1, 2, 0))
    dtype = np.dtype(kind.dtype)
    if dtype.kind != "f" and np.isnan(values).any():
        raise InputError(f"pixels hold NaN, which {kind} cannot; replace them")
    if dtype.kind == "f":
        return values.astype(dtype)
    if dtype.kind == "b":
        return values > 0.5
    most = np.iinfo(dtype).max
    return np.rint(values.clip(0, 1) * np.float32(most)).astype(dtype)
