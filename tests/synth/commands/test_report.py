"""Energies as a table and as a picture, scores as text, progress on a terminal."""

import io
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from kwatra.base import compiled
from synth.commands.progress import progress_line, work_line
from synth.commands.report import energy_writer, score_table

ROWS = [
    {"level": 0, "factor": 2, "width": 16, "iteration": 0, "route": "exact", "texture": 0.5, "total": 0.5},
    {"level": 0, "factor": 2, "width": 16, "iteration": 1, "route": "exact", "texture": 0.4, "total": 0.4},
    {"level": 1, "factor": 1, "width": 8, "iteration": 0, "route": "exact", "texture": 0.2, "soft": 0.1, "total": 0.3},
]


def test_table_has_a_column_for_every_term(tmp_path: Path) -> None:
    energy_writer(Path("e.csv"), ROWS)(tmp_path / "made")
    lines = (tmp_path / "made").read_text().splitlines()
    assert lines[0] == "level,factor,width,iteration,route,texture,total,soft"
    assert lines[1] == "0,2,16,0,exact,0.5,0.5,"
    assert lines[3] == "1,1,8,0,exact,0.2,0.3,0.1"


def test_table_of_a_run_without_iterations_has_its_heads(tmp_path: Path) -> None:
    energy_writer(Path("e.csv"), [])(tmp_path / "made")
    assert (tmp_path / "made").read_text() == "level,factor,width,iteration,route,changed,texture,total\n"


@pytest.mark.parametrize("rows", [[], ROWS, ROWS[:1], [{**row, "texture": 0.0, "total": 0.0} for row in ROWS[:2]]])
def test_picture_is_drawn_whatever_the_energies(tmp_path: Path, rows: list[dict[str, object]]) -> None:
    energy_writer(Path("e.png"), rows)(tmp_path / "made.png")
    with Image.open(tmp_path / "made.png") as image:
        assert image.size == (960, 480)
        assert np.asarray(image).min() < 100


def test_picture_has_a_curve_for_each_part_of_a_level(tmp_path: Path) -> None:
    def drawn(rows: list[dict[str, Any]]) -> np.ndarray:
        energy_writer(Path("e.png"), rows)(tmp_path / "made.png")
        with Image.open(tmp_path / "made.png") as image:
            return np.asarray(image).copy()

    parts = [{"label": number, **row} for number in range(2) for row in ROWS[:2]]
    whole = [{**row, "iteration": number} for number, row in enumerate([*ROWS[:2], *ROWS[:2]])]
    assert (drawn(parts) != drawn(whole)).any()  # no line leads from one to the next
    levels = [{**row, "level": number // 2} for number, row in enumerate(whole)]
    np.testing.assert_array_equal(drawn(parts), drawn(levels))


def test_picture_falls_where_the_energy_falls(tmp_path: Path) -> None:
    energy_writer(Path("e.png"), ROWS[:2])(tmp_path / "made.png")
    with Image.open(tmp_path / "made.png") as image:
        curve = (np.asarray(image)[50:] == (0x1F, 0x6F, 0xB4)).all(-1)
    heights = [np.flatnonzero(curve[:, x]).mean() for x in (100, 500, 850)]
    assert heights == sorted(heights)


def test_scores_line_up() -> None:
    text = score_table({"a.png": {"forward": 0.1, "overall": 1.0}, "longer name.png": {"forward": 0.2, "overall": 0.3}})
    lines = text.splitlines()
    assert len({len(line) for line in lines}) == 1
    assert lines[2].split() == ["longer", "name.png", "0.2000", "0.3000"]


class Stream(io.StringIO):
    """A stream that says whether it is a terminal."""

    def __init__(self, terminal: bool) -> None:
        super().__init__()
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_for_terminals_only(monkeypatch: pytest.MonkeyPatch, terminal: bool) -> None:
    stream = Stream(terminal)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with progress_line("brick") as callback:
        callback(SimpleNamespace(fraction=0.5, level=1, attempt=1, tries=1))
    assert ("brick" in stream.getvalue()) == terminal
    assert ("50%" in stream.getvalue()) == terminal


@pytest.mark.parametrize("line", [progress_line, work_line])
@pytest.mark.parametrize("first", [True, False])
def test_a_terminal_is_told_when_loops_are_compiled(monkeypatch: pytest.MonkeyPatch, line: Any, first: bool) -> None:
    stream = Stream(True)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(compiled, "compiling", lambda: first)
    with line("brick"):
        pass
    assert ("compiling loops" in stream.getvalue()) == first
