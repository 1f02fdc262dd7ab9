"""NumPy's .npy and .npz as arrays, and back."""

import io
import math
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, TypeVar

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import Array
from synth.io.outputs import Writer, bytes_writer

T = TypeVar("T")

MOST_BYTES = 2**31
"""What the arrays of a file may hold: as much as a flow of 2^28 pixels."""


def read_npy(path: Path) -> Array:
    """The array of an .npy file. Raises InputError for a damaged or too large file, and for OSError what it is."""
    with path.open("rb") as file:
        return _told(path, _array, file)


def read_npz(path: Path) -> Mapping[str, Array]:
    """The arrays of an .npz file by name. Raises as `read_npy` does, and for what is no array."""
    with path.open("rb") as file:
        return _told(path, _arrays, file)


def npy_bytes(array: Array) -> bytes:
    """An .npy file's bytes."""
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def npz_bytes(arrays: Mapping[str, Array], compressed: bool = True) -> bytes:
    """An .npz file's bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), npy_bytes(array), archive.compression)
    return stream.getvalue()


def npy_writer(array: Array) -> Writer:
    """What writes an .npy file."""
    return bytes_writer(npy_bytes(array))


def _arrays(file: IO[bytes]) -> Mapping[str, Array]:
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        _check_bytes(sum(member.file_size for member in members))
        found = {}
        for member in members:
            with archive.open(member) as stream:
                found[member.filename.removesuffix(".npy")] = _array(stream)
        return found


def _array(file: IO[bytes]) -> Array:
    """The array at the beginning of a stream that can seek, its size checked before it is read."""
    read_head = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    shape, _, dtype = read_head[np.lib.format.read_magic(file)](file)
    _check_bytes(math.prod(shape) * dtype.itemsize)
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def _check_bytes(count: int) -> None:
    if count > MOST_BYTES:
        raise _TooLarge(count)


class _TooLarge(Exception):
    """Arrays of so many bytes."""


def _told(path: Path, read: Callable[[IO[bytes]], T], file: IO[bytes]) -> T:
    """What `read` makes of a file, its errors in one sentence."""
    try:
        return read(file)
    except _TooLarge as error:
        raise InputError(
            f"{path} holds arrays of {error.args[0]} bytes; at most {MOST_BYTES} are read, so store less"
        ) from None
    except OSError:
        raise
    except Exception as error:  # each kind of damage has its own
        raise InputError(f"{path} is no NumPy file of numbers, or is cut short; get it anew") from error
