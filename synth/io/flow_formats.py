"""Flow as the bytes of a file, and back. x comes first everywhere.

- .flo: float 202021.25, width and height as int32, then x and y of each pixel as float32, all little-endian. A value
  beyond 1e9 says that a vector is not known (Baker and others, A Database and Evaluation Methodology for Optical Flow,
  2007).
- .png: three channels of 16 bits, x * 64 + 2^15, y * 64 + 2^15, and 1 where the vector is known (Geiger, Lenz and
  Urtasun, Are we ready for Autonomous Driving?, 2012): up to 512 px in steps of 1/64.
- .npy, .npz: (2, H, W) or (H, W, 2), in time (T, 2, H, W) or (T, H, W, 2); x first; not known as in .flo. An archive
  holds one array, or names the one to read `flow` or `velocity`. One whose name ends with `staggered` has its vectors
  on the pixels' left and upper sides, one more of them along each axis, as fluid simulations (PhiFlow, mantaflow) write
  them; they are averaged to the centers.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from kwatra.base import InputError
from synth.io.kinds import MOST_PIXELS, RGB, Array, Kind
from synth.io.numpy_files import npy_bytes, npz_bytes, read_npy, read_npz
from synth.io.png import png_bytes, png_pixels

_MAGIC = 202021.25
UNKNOWN = 1e9
WRITTEN_FOR_UNKNOWN = 1e10
_KITTI_STEPS, _KITTI_ZERO = 64.0, 2.0**15


def _read_flo(path: Path) -> Array:
    data = path.read_bytes()
    if len(data) < 12:
        raise InputError(f"{path} is cut short, not even its head of 12 bytes is there; get it anew")
    if np.frombuffer(data, "<f4", 1)[0] != np.float32(_MAGIC):
        raise InputError(f"{path} is no Middlebury flow, it does not begin with the number {_MAGIC}; check the file")
    width, height = (int(size) for size in np.frombuffer(data, "<i4", 2, 4))
    if min(width, height) < 1 or width * height > MOST_PIXELS:
        raise InputError(f"{path} says that it is {width}x{height}, which no flow is; get it anew")
    if len(data) != 12 + 8 * width * height:
        raise InputError(
            f"{path} has {len(data)} bytes, but {12 + 8 * width * height} make a flow of {width}x{height}; get it anew"
        )
    return np.frombuffer(data, "<f4", offset=12).reshape(height, width, 2).transpose(2, 0, 1)


def _flo_bytes(path: Path, vectors: Array, known: Array) -> bytes:
    size = np.array(vectors.shape[:0:-1], "<i4").tobytes()
    written = _marked(vectors, known).transpose(1, 2, 0).astype("<f4")
    return np.array(_MAGIC, "<f4").tobytes() + size + written.tobytes()


def _read_kitti(path: Path) -> Array:
    data = path.read_bytes()
    try:
        pixels = png_pixels(path, data)
    except Exception as error:
        raise InputError(f"{path} is no PNG that can be read, or is cut short; get it anew") from error
    if pixels.dtype != np.uint16 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise InputError(
            f"{path} holds {pixels.dtype} pixels of shape {pixels.shape}; a KITTI flow has three channels of 16 bits"
        )
    vectors = (pixels[..., :2].astype(np.float32) - _KITTI_ZERO) / _KITTI_STEPS
    return np.where(pixels[..., 2:] > 0, vectors, WRITTEN_FOR_UNKNOWN).transpose(2, 0, 1)


def _kitti_bytes(path: Path, vectors: Array, known: Array) -> bytes:
    steps = np.rint(vectors * _KITTI_STEPS + _KITTI_ZERO)
    if steps.min() < 0 or steps.max() > 2**16 - 1:
        raise InputError(f"{path} cannot hold vectors of 512 px and more; end it with .flo")
    pixels = np.stack([*np.where(known, steps, 0), known]).transpose(1, 2, 0).astype(np.uint16)
    return png_bytes(pixels, Kind("uint16", RGB))


def _read_array(path: Path) -> Array:
    return _channel_first(path, read_npy(path))


def _read_archive(path: Path) -> Array:
    arrays = read_npz(path)
    names = list(arrays)
    chosen = [name for name in names if name.split("_")[0] in ("flow", "velocity")] if len(names) > 1 else names
    if len(chosen) != 1:
        raise InputError(f"{path} holds the arrays {', '.join(names) or 'none'}; name the one to read flow or velocity")
    array = arrays[chosen[0]]
    return _centered(path, array) if chosen[0].endswith("staggered") else _channel_first(path, array)


def _centered(path: Path, array: Array) -> Array:
    """A staggered grid (H + 1, W + 1, 2) or (T, H + 1, W + 1, 2) averaged to the pixels' centers, (..., 2, H, W).

    x is known on pixels' left sides and y on their upper ones; the last row of x and column of y mean nothing.
    """
    if array.ndim not in (3, 4) or array.shape[-1] != 2 or min(array.shape[-3:-1]) < 2:
        raise InputError(f"{path} holds an array {array.shape}; a staggered grid is (H + 1, W + 1, 2), or so in time")
    array = _numbers(path, array)
    x = (array[..., :-1, :-1, 0] + array[..., :-1, 1:, 0]) / 2
    y = (array[..., :-1, :-1, 1] + array[..., 1:, :-1, 1]) / 2
    return _steady(np.stack([x, y], -3))


def _channel_first(path: Path, array: Array) -> Array:
    if array.ndim in (3, 4) and array.size:
        if array.shape[-3] == 2:
            return _steady(_numbers(path, array))
        if array.shape[-1] == 2:
            return _steady(np.moveaxis(_numbers(path, array), -1, -3))
    raise InputError(f"{path} holds an array {array.shape}; a flow is (2, H, W) or (H, W, 2), or (T, 2, H, W) in time")


def _numbers(path: Path, array: Array) -> Array:
    if array.dtype.kind not in "fiu":
        raise InputError(f"{path} holds {array.dtype}; a flow is made of numbers")
    return array.astype(np.float32)


def _steady(array: Array) -> Array:
    """A sequence of one flow is a steady one."""
    return array[0] if array.ndim == 4 and len(array) == 1 else array


def _npy_bytes(path: Path, vectors: Array, known: Array) -> bytes:
    return npy_bytes(_marked(vectors, known))


def _npz_bytes(path: Path, vectors: Array, known: Array) -> bytes:
    return npz_bytes({"flow": _marked(vectors, known)})


def _marked(vectors: Array, known: Array) -> Array:
    return np.where(known[..., None, :, :], vectors, WRITTEN_FOR_UNKNOWN).astype(np.float32)


READERS: dict[str, Callable[[Path], Array]] = {
    ".flo": _read_flo,
    ".png": _read_kitti,
    ".npy": _read_array,
    ".npz": _read_archive,
}
"""By ending: a file to vectors (2, H, W) or (T, 2, H, W); beyond UNKNOWN where they are not known."""

ENCODERS: dict[str, Callable[[Path, Array, Array], bytes]] = {
    ".flo": _flo_bytes,
    ".png": _kitti_bytes,
    ".npy": _npy_bytes,
    ".npz": _npz_bytes,
}
"""By ending: vectors and where they are known to a file's bytes."""
