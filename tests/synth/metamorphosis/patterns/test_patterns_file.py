"""The patterns file: what it holds comes back, and what cannot be meant is refused in a sentence."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kwatra import InputError
from synth.metamorphosis.patterns import Patterns, patterns_writer, read_patterns

TRIANGLE = [[10, 10], [20, 10], [15.25, 18]]


def content(**changes: Any) -> dict[str, Any]:
    whole = {"format": "kwatra patterns", "version": 1, "width": 64, "height": 48, "landmarks": TRIANGLE}
    return {key: value for key, value in (whole | changes).items() if value != "left out"}


def read(tmp_path: Path, text: Any) -> Patterns:
    path = tmp_path / "some.json"
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return read_patterns(path)


@pytest.mark.parametrize("found", [None, np.empty((0, 3, 2)), np.array([TRIANGLE, TRIANGLE]) + 5])
@pytest.mark.parametrize("closed", [False, True])
def test_what_is_written_comes_back(tmp_path: Path, found: np.ndarray | None, closed: bool) -> None:
    patterns = Patterns((48, 64), np.array(TRIANGLE), found, closed)
    patterns_writer(patterns)(tmp_path / "there.json")
    back = read_patterns(tmp_path / "there.json")
    assert (back.size, back.closed) == (patterns.size, closed)
    assert np.array_equal(back.landmarks, patterns.landmarks)
    assert (back.found is None) == (found is None)
    assert found is None or np.array_equal(back.found, found)


def test_a_person_may_leave_out_what_is_not_needed(tmp_path: Path) -> None:
    patterns = read(tmp_path, content())
    assert patterns.found is None
    assert not patterns.closed
    assert patterns.size == (48, 64)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "is no JSON"),
        ([1], "no file of patterns"),
        (content(format="other"), "no file of patterns"),
        (content(version=2), "its version is 2; this program reads version 1"),
        (content(versoin=1, color="red"), "unknown keys 'versoin', 'color'"),
        (content(width="left out"), "lacks 'width'"),
        (content(width=0), "whole numbers"),
        (content(height=4.5), "whole numbers"),
        (content(closed=1), "closed is true or false"),
        (content(landmarks=[[1, 2], [3]]), r"no list of \[x, y\]"),
        (content(landmarks=[[1, 2], ["a", 3]]), r"no list of \[x, y\]"),
        (content(landmarks=TRIANGLE[:2]), "has 2 landmarks; give at least 3"),
        (content(landmarks=[*TRIANGLE, [64, 3]]), r"at \(64, 3\), outside of the 64x48 image"),
        (content(landmarks=[*TRIANGLE, [float("nan"), 3]]), "outside"),
        (content(landmarks=[[5, 5]] * 3), "at one place"),
        (content(patterns=3), '"patterns" is a list'),
        (content(patterns=[TRIANGLE, TRIANGLE[:2]]), "pattern 2 has 2 landmarks but the first one 3"),
        (content(patterns=[[[-1, 0], [3, 0], [0, 3]]]), r"pattern 1 has a landmark at \(-1, 0\)"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, text: Any, match: str) -> None:
    with pytest.raises(InputError, match=match):
        read(tmp_path, text)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        read_patterns(tmp_path / "none.json")
