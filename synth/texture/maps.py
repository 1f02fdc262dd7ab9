"""Maps that belong to an exemplar (normals, height, masks), and the map of where each output pixel came from.

A map is carried along by lookup: output pixel p gets the map's value at the exemplar pixel that p came from. Values,
dtype and bit depth stay exact. A map whose name begins with normal holds directions, which are turned where the
exemplar's mirrored or turned variants were used (`synth.texture.normals`).
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kwatra.base import InputError
from synth.io.images import array_writer, check_output, read_array, read_values
from synth.io.kinds import Array, Kind
from synth.io.numpy_files import npy_writer, read_npy
from synth.io.outputs import Writer
from synth.io.streams import STREAM
from synth.io.unreadable import reading
from synth.texture.normals import coded, decoded, is_normal, points_down, turned_normals
from synth.texture.synthesis import taken
from synth.words import counted

SOURCE_SUFFIXES = (".npy", ".png")
_SOURCE_PNG = Kind("uint16", ("R", "G", "B"))


@dataclass(frozen=True)
class Map:
    """A map of the exemplars: its name, one array (H, W, C) per exemplar, their kind, and the file to write."""

    name: str
    arrays: list[Array]
    kind: Kind
    output: Path


def read_map(request: str, sizes: list[tuple[int, int]], output: Path) -> Map:
    """Read what `--also NAME=FILE[,FILE...]` asks for: one file per exemplar, of the same (height, width).

    `output` is the file of the synthesized image; the map goes beside it as STEM_NAME with the map's own ending.
    """
    name, files = _split(request, len(sizes))
    if output == STREAM:
        raise InputError("--also writes beside the output, which is a stream; name a file with -o")
    arrays, kinds = zip(*(read_values(file) for file in files), strict=True)
    for file, array, size in zip(files, arrays, sizes, strict=True):
        if array.shape[:2] != size:
            raise InputError(
                f"{file} is {_size(array.shape[:2])} but its exemplar is {_size(size)}; a map has its exemplar's size"
            )
    for file, kind in zip(files, kinds, strict=True):
        if (kind.dtype, kind.channels) != (kinds[0].dtype, kinds[0].channels):
            raise InputError(f"{file} holds {kind} but {files[0]} holds {kinds[0]}; save both maps alike")
    return Map(name, list(arrays), kinds[0], output.with_name(f"{output.stem}_{name}{files[0].suffix}"))


def guide_files(request: str, count: int) -> list[Path]:
    """What `--guide MAP[,MAP]=OUTPUT_MAP` names: maps, one per exemplar, and last the output's."""
    first, equals, last = request.rpartition("=")
    if not (equals and first and last):
        raise InputError(f"--guide is {request!r}; write EXEMPLAR_MAP=OUTPUT_MAP, as labels.png=wanted.png")
    files = [Path(part) for part in (first.split(",") if count > 1 else [first])]
    if len(files) != count:
        raise InputError(
            f"--guide names {counted(len(files), 'map')} for {counted(count, 'exemplar')}; give one each, with commas"
        )
    return [*files, Path(last)]


def read_guide(request: str, count: int) -> tuple[list[Array], Array]:
    """Read what `--guide MAP[,MAP]=OUTPUT_MAP` asks for: maps (H, W, C), one per exemplar, and the output's."""
    files = guide_files(request, count)
    arrays, kinds = zip(*(read_array(file) for file in files), strict=True)
    for file, kind in zip(files, kinds, strict=True):
        if (kind.dtype, kind.channels) != (kinds[-1].dtype, kinds[-1].channels):
            raise InputError(f"{file} holds {kind} but {files[-1]} holds {kinds[-1]}; save both maps alike")
    return list(arrays[:-1]), arrays[-1]


def map_writer(carried: Map, source: Array, turns: Array | None = None) -> Writer:
    """What writes a map rearranged as `source` (3, H, W) says: number of the exemplar, row, column; -1 leaves 0.

    turns (2, 2, H, W): what takes directions of the exemplar to those of the output, None where nothing is turned.
    """
    return array_writer(carried.output, rearranged(carried.name, carried.arrays, source, turns), carried.kind)


def rearranged(name: str, arrays: list[Array], source: Array, turns: Array | None) -> Array:
    """Maps (*S, C) as `map_writer` writes them."""
    made = taken(arrays, source)
    return turned_normals(made, turns, points_down(name)) if is_normal(name) else made


def check_source_output(path: Path, sizes: list[tuple[int, int]], overwrite: bool) -> None:
    """Refuse, before any work, a `--map` file that could not be written."""
    check_output(path, None, overwrite, SOURCE_SUFFIXES)
    if path.suffix.lower() == ".png" and max(max(size) for size in sizes) > 2**16:
        raise InputError(f"{path} cannot hold coordinates above 65535; end it with .npy")


def source_writer(path: Path, source: Array, turns: Array | None = None) -> Writer:
    """What writes the source coordinates (3, H, W) = (exemplar, y, x).

    .npy: int32, as given, and of pieces that may be turned a fourth row, how they are (`synth.texture.normals.coded`).
    .png: 16-bit color, R = x, G = y, B = exemplar, without that.
    """
    if path.suffix.lower() == ".png":
        colors = np.ascontiguousarray(source[::-1].transpose(1, 2, 0)).astype(np.uint16)
        return array_writer(path, colors, _SOURCE_PNG)

    rows = source if turns is None else np.concatenate([source, coded(turns)[None]])
    return npy_writer(rows.astype(np.int32))


def read_source(path: Path) -> tuple[Array, Array | None]:
    """Read source coordinates (3, H, W) int64 = (exemplar, y, x) as `source_writer` writes them; -1: from none.

    With them come the turns (2, 2, H, W), None where the file has none.

    Raises InputError for a file that holds something else.
    """
    if path.suffix.lower() == ".png":
        colors, kind = read_array(path)
        if (kind.dtype, kind.channels) != (_SOURCE_PNG.dtype, _SOURCE_PNG.channels):
            raise InputError(f"{path} holds {kind}; a map of where pixels come from holds {_SOURCE_PNG}")
        source = colors.astype(np.int64).transpose(2, 0, 1)[::-1]
        return np.where(source[0] == 2**16 - 1, -1, source), None
    with reading(path, "a map that --map wrote"):
        source = read_npy(path)
    if source.ndim != 3 or len(source) not in (3, 4) or source.dtype.kind not in "iu" or 0 in source.shape:
        raise InputError(f"{path} holds {source.dtype} of shape {source.shape}; a map of where pixels come from is "
                         "int32 (3, H, W), as --map writes it")  # fmt: skip
    source = source.astype(np.int64)
    return source[:3], None if len(source) == 3 else decoded(source[3])


def _split(request: str, count: int) -> tuple[str, list[Path]]:
    name, equals, rest = request.partition("=")
    if not (equals and rest and re.fullmatch(r"[\w-]+", name)):
        raise InputError(f"--also is {request!r}; write NAME=FILE, for example normal=brick_n.png")
    files = [Path(part) for part in (rest.split(",") if count > 1 else [rest])]
    if len(files) != count:
        raise InputError(
            f"--also {name} names {counted(len(files), 'file')} for {counted(count, 'exemplar')}; "
            "give one each, with commas"
        )
    return name, files


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]}"
