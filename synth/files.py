"""Images in and out of files: read with their kind, written whole or not at all.

Integer pixels become [0, 1] and come back exactly; float pixels keep their values, whatever their range. Nothing is
written in place: every file is made beside its target, forced to disk, and moved there when all files of the call
are complete.
"""

import errno
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from kwatra.errors import InputError
from synth.formats import Array, Kind, decode, encode, suffixes_for

Writer = Callable[[Path], None]

_DTYPES = ("bool", "uint8", "uint16", "float16", "float32", "float64")


@dataclass(frozen=True)
class Picture:
    """An image file's content: pixels (C, H, W) float32 and the kind of file they came from.

    Pixels are in [0, 1] where the file holds integers, else the file's own values.
    """

    pixels: Tensor
    kind: Kind


def read_image(path: str | Path) -> Picture:
    """Read a PNG, JPEG, TIFF or EXR file.

    Raises InputError when the file is missing, is no such image, is damaged, or holds NaN or infinite pixels.
    """
    array, kind = read_array(path)
    if kind.dtype not in _DTYPES:
        raise InputError(f"{path} holds {kind.dtype} pixels; save it with 8 or 16 bits or as float")
    return Picture(_to_pixels(array), kind)


def write_image(path: str | Path, pixels: Tensor, kind: Kind, overwrite: bool = False) -> None:
    """Write pixels (C, H, W) as a file of this kind; the ending of `path` names the format.

    Raises InputError when the format cannot hold the kind, the file exists and `overwrite` is not set, its folder
    does not exist, or it cannot be written; then no file is left and an existing one is as it was.
    """
    check_output(path, kind, overwrite)
    write_files({Path(path): image_writer(path, pixels, kind)})


def read_array(path: str | Path) -> tuple[Array, Kind]:
    """The pixels (H, W, C) as the file holds them, finite, and their kind. Raises as `read_image` does."""
    path = Path(path)
    try:
        array, kind = decode(path)
    except FileNotFoundError:
        raise InputError(f"{path} does not exist; check the name") from None
    except IsADirectoryError:
        raise InputError(f"{path} is a folder; name an image file") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error}); check its permissions") from error
    bad = array.size - int(np.isfinite(array).sum()) if array.dtype.kind == "f" else 0
    if bad:
        raise InputError(f"{path} has {bad} values that are NaN or infinite; replace them by finite ones")
    return array, kind


def image_writer(path: str | Path, pixels: Tensor, kind: Kind) -> Writer:
    """What writes pixels (C, H, W) in the format that the ending of `path` names; see `write_files`."""
    return array_writer(path, _from_pixels(pixels, kind), kind)


def array_writer(path: str | Path, array: Array, kind: Kind) -> Writer:
    """What writes an array (H, W, C) that already has the kind's dtype; see `write_files`."""
    suffix = Path(path).suffix.lower()
    return lambda target: encode(target, array, kind, suffix)


def check_output(path: str | Path, kind: Kind | None, overwrite: bool, suffixes: Iterable[str] = ()) -> None:
    """Refuse, before any work, a file that could not be written.

    The ending must be one that can hold `kind`, or where that is None one of `suffixes`.
    """
    path = Path(path)
    allowed = tuple(suffixes) if kind is None else suffixes_for(kind)
    if path.suffix.lower() not in allowed:
        what = "it" if kind is None else f"{kind} pixels"
        raise InputError(f"{path} has an ending that cannot hold {what}; end it with {' or '.join(allowed)}")
    if path.is_dir():
        raise InputError(f"{path} is a folder; name a file")
    if path.exists() and not overwrite:
        raise InputError(f"{path} exists; name another file or allow it with --overwrite (overwrite=True)")
    if not path.parent.is_dir():
        raise InputError(f"{path} cannot be written because the folder {path.parent} does not exist; make it first")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path} cannot be written because the folder {path.parent} is read-only; choose another")


def write_files(writers: Mapping[Path, Writer]) -> None:
    """Write several files or folders, all or none: each writer gets the path of a temporary one beside its target.

    Raises InputError when one cannot be written; the temporary ones are removed then, whatever ends the call.
    """
    temporary: dict[Path, Path] = {}
    try:
        for path, writer in writers.items():
            target = path.resolve()
            temporary[target] = target.with_name(f".{os.getpid()}.{target.name[-200:]}")
            with _told(path):
                writer(temporary[target])
                if temporary[target].is_file():
                    _force_to_disk(temporary[target])
        for target, made in temporary.items():
            with _told(target):
                _put(made, target)
    finally:
        for made in temporary.values():
            _remove(made)


def _put(made: Path, target: Path) -> None:
    """Move a file or folder to where another may be; if that fails the other is back in its place."""
    if not target.is_dir():
        os.replace(made, target)
        return
    old = target.with_name(f".{os.getpid()}.old.{target.name[-200:]}")
    target.rename(old)
    try:
        made.rename(target)
    except OSError:
        old.rename(target)
        raise
    shutil.rmtree(old)


def _remove(made: Path) -> None:
    if made.is_dir():
        shutil.rmtree(made)
    else:
        made.unlink(missing_ok=True)


def _to_pixels(array: Array) -> Tensor:
    values = array.astype(np.float32)
    if array.dtype.kind == "u":
        values /= np.iinfo(array.dtype).max
    return torch.from_numpy(np.ascontiguousarray(values.transpose(2, 0, 1)))


def _from_pixels(pixels: Tensor, kind: Kind) -> Array:
    if pixels.ndim != 3 or pixels.shape[0] != len(kind.channels):
        raise InputError(
            f"pixels have shape {tuple(pixels.shape)}; give (C, H, W) with {len(kind.channels)} channels for {kind}"
        )
    values = np.ascontiguousarray(pixels.detach().cpu().numpy().transpose(1, 2, 0))
    dtype = np.dtype(kind.dtype)
    if dtype.kind == "f":
        return values.astype(dtype)
    if dtype.kind == "b":
        return values > 0.5
    most = np.iinfo(dtype).max
    return np.rint(values.clip(0, 1) * np.float32(most)).astype(dtype)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say an OSError in one sentence that names the file."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise InputError(f"{path} was not written because the disk is full; free some space") from error
        raise InputError(f"{path} was not written ({error.strerror or error}); choose another place") from error


def _force_to_disk(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())
