"""The patterns of a texture, and the file that a person, or a drawing tool, reads and writes.

The file is JSON:

    {"format": "kwatra patterns", "version": 1, "width": 128, "height": 128,
     "closed": false,
     "landmarks": [[12.5, 40], [20, 44], [14, 51.5]],
     "patterns": [
      [[40.2, 38.9], [47.8, 43], [42, 50.4]]
     ]}

width and height are the image's. Coordinates are pixels, x first; [0, 0] is the center of the top left pixel. landmarks
is one representative pattern: at least 3 points in order. The first of one texture becomes the first of the other, and
so on. With closed (false where left out) they are an outline whose order may begin anywhere: the best beginning is
found. patterns are all of them, each with as many landmarks; where it is left out they are to be detected.

One file may also hold the landmarks of one pattern of A and one of B, whose orders are to be seen together:

    {"format": "kwatra landmarks", "version": 1,
     "a": [[12.5, 40], [20, 44], [14, 51.5]],
     "b": [[8, 31], [22, 30.5], [17, 42]]}
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kwatra.base import InputError
from synth.io.outputs import Writer
from synth.io.unreadable import reading

Array = NDArray[np.float64]

FORMAT, PAIR_FORMAT, VERSION = "kwatra patterns", "kwatra landmarks", 1
LEAST = 3
_KEYS = ("format", "version", "width", "height", "closed", "landmarks", "patterns")
_NEEDED = ("format", "version", "width", "height", "landmarks")
_PAIR_KEYS = ("format", "version", "a", "b")

_Read = TypeVar("_Read")


@dataclass(frozen=True)
class Patterns:
    """The patterns of an image of size (height, width).

    landmarks (m, 2): the representative one, x first, in px. found (n, m, 2): all of them; None where they are yet to
    be detected. closed: landmarks are an outline whose order may begin anywhere.
    """

    size: tuple[int, int]
    landmarks: Array
    found: Array | None = None
    closed: bool = False

    def __post_init__(self) -> None:
        _check_landmarks("the pattern", self.landmarks, self.size)
        if self.found is not None:
            for number, each in enumerate(self.found):
                _check_landmarks(f"pattern {number + 1}", each, self.size)


def read_patterns(path: str | Path) -> Patterns:
    """Read a patterns file.

    Raises InputError if it is missing or no JSON, is of another format or version, has unknown keys, or landmarks are
    fewer than 3, outside of the image, or not as many in every pattern.
    """
    return _told(path, _patterns)


def read_landmarks(path: str | Path, sizes: tuple[tuple[int, int], tuple[int, int]]) -> tuple[Patterns, Patterns]:
    """Read the landmarks of one pattern of A and one of B, images of these sizes (height, width).

    Raises InputError as `read_patterns`, and if A has not as many as B.
    """
    return _told(path, lambda content: _pair(content, sizes))


def _told(path: str | Path, read: Callable[[Any], _Read]) -> _Read:
    """What is read from the content of a JSON file; errors name the file."""
    with reading(path, "a JSON file"):
        text = Path(path).read_bytes()
    try:
        content = json.loads(text)
    except ValueError as error:
        raise InputError(f"{path} is no JSON ({error}); write it as kwatra patterns --help shows") from error
    try:
        return read(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def patterns_writer(patterns: Patterns) -> Writer:
    """What writes a patterns file, one pattern a line; see `synth.io.outputs.write_files`."""
    lines = [
        f'{{"format": "{FORMAT}", "version": {VERSION}, "width": {patterns.size[1]}, "height": {patterns.size[0]},',
        f' "closed": {json.dumps(patterns.closed)},',
        f' "landmarks": {_points(patterns.landmarks)}',
    ]
    if patterns.found is not None:
        lines[-1] += ","
        lines += [' "patterns": [', ",\n".join(f"  {_points(each)}" for each in patterns.found), " ]"]
    text = "\n".join(lines) + "}\n"

    def write(target: Path) -> None:
        target.write_text(text, "utf-8")

    return write


def _check_keys(content: Any, form: str, keys: Sequence[str], needed: Sequence[str]) -> None:
    """InputError for what is of another format or version, or has not the keys."""
    if not isinstance(content, Mapping) or content.get("format") != form:
        raise InputError(f'it is no file of {form.removeprefix("kwatra ")}; its "format" is "{form}"')
    if content.get("version") != VERSION:
        raise InputError(f"its version is {content.get('version')!r}; this program reads version {VERSION}")
    unknown = [repr(key) for key in content if key not in keys]
    if unknown:
        raise InputError(f"it has unknown keys {', '.join(unknown)}; the keys are {', '.join(keys)}")
    missing = [repr(key) for key in needed if key not in content]
    if missing:
        raise InputError(f"it lacks {', '.join(missing)}; add that")


def _pair(content: Any, sizes: tuple[tuple[int, int], tuple[int, int]]) -> tuple[Patterns, Patterns]:
    _check_keys(content, PAIR_FORMAT, _PAIR_KEYS, _PAIR_KEYS)
    a, b = (Patterns(size, _array(name, content[name])) for name, size in zip("ab", sizes, strict=True))
    if len(a.landmarks) != len(b.landmarks):
        raise InputError(f"it has {len(a.landmarks)} landmarks in A and {len(b.landmarks)} in B; give equally many")
    return a, b


def _patterns(content: Any) -> Patterns:
    _check_keys(content, FORMAT, _KEYS, _NEEDED)
    size = (content["height"], content["width"])
    if not all(type(side) is int and side > 0 for side in size) or type(content.get("closed", False)) is not bool:
        raise InputError("its width and height are whole numbers of pixels above 0 and closed is true or false")
    landmarks = _array("landmarks", content["landmarks"])
    found = [_array(f"pattern {number}", each) for number, each in enumerate(_listed(content.get("patterns")), 1)]
    unequal = [number for number, each in enumerate(found, 1) if len(each) != len(landmarks)]
    if unequal:
        raise InputError(
            f"pattern {unequal[0]} has {len(found[unequal[0] - 1])} landmarks but the first one {len(landmarks)}; "
            "give every pattern as many"
        )
    listed = "patterns" in content
    every = np.stack(found) if found else np.empty((0, *landmarks.shape))
    return Patterns(size, landmarks, every if listed else None, content.get("closed", False))


def _listed(patterns: Any) -> list[Any]:
    if not isinstance(patterns, list | None):
        raise InputError('"patterns" is a list of patterns, each a list of [x, y]; leave it out to have them detected')
    return patterns or []


def _array(name: str, points: Any) -> Array:
    try:
        array = np.asarray(points, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"{name} is no list of [x, y]; write it as [[12, 40], [20, 44], [14, 51.5]]")
    return array


def _check_landmarks(name: str, landmarks: Array, size: tuple[int, int]) -> None:
    if len(landmarks) < LEAST:
        raise InputError(f"{name} has {len(landmarks)} landmarks; give at least {LEAST}")
    outside = ~((landmarks >= 0) & (landmarks <= [size[1] - 1, size[0] - 1])).all(1)
    if outside.any():
        x, y = landmarks[outside][0]
        raise InputError(
            f"{name} has a landmark at ({x:.6g}, {y:.6g}), outside of the {size[1]}x{size[0]} image; move it inside"
        )
    if np.ptp(landmarks, 0).max() < 1:
        raise InputError(f"{name} has all landmarks at one place; move them apart")


def _points(points: Array) -> str:
    return json.dumps([[round(float(x), 2), round(float(y), 2)] for x, y in points])
