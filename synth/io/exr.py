"""OpenEXR as arrays, and back."""

import errno
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import Array, Kind, check_extent
from synth.io.quiet import quiet


def read_exr(path: Path) -> tuple[Array, Kind]:
    """Pixels (H, W, C) and their kind."""
    import OpenEXR

    with quiet(), OpenEXR.File(str(path), header_only=True) as file:
        _check_heads(path, file.parts)
    with quiet(), OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        names = tuple(sorted(channels, key=_exr_order))
        planes = [np.array(channels[name].pixels) for name in names]
    if len({plane.shape for plane in planes}) > 1:
        raise InputError(f"{path} has channels of different sizes; save it without subsampling")
    pixels = np.stack([plane.astype(np.result_type(*planes), copy=False) for plane in planes], -1)
    return pixels, Kind(pixels.dtype.name, names, premultiplied="A" in names)


def _check_heads(path: Path, parts: Sequence[Any]) -> None:
    if len(parts) > 1:
        raise InputError(f"{path} has {len(parts)} parts; save one as a file of its own")
    head = parts[0].header
    low, high = head["dataWindow"]
    check_extent(path, int(high[0]) - int(low[0]) + 1, int(high[1]) - int(low[1]) + 1, len(head["channels"]))


def _exr_order(name: str) -> tuple[str, int, str]:
    layer, _, channel = name.rpartition(".")
    return layer, {"R": 0, "G": 1, "B": 2, "A": 4}.get(channel, 3), channel


def write_exr(path: Path, pixels: Array, kind: Kind) -> None:
    """Write an OpenEXR file."""
    import OpenEXR

    planes = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate(kind.channels)}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with quiet():
        try:
            with OpenEXR.File(header, planes) as file:
                file.write(str(path))
            read_exr(path)
        except Exception as error:  # the library does not notice a full disk; reading back does
            raise OSError(errno.EIO, "it came out incomplete; is the disk full?") from error
