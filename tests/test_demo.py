"""The demo, shrunk."""

import runpy
import sys
from pathlib import Path

import pytest

from synth import read_image


def test_demo_writes_what_it_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = Path(__file__).parent.parent / "scripts" / "demo.py"
    monkeypatch.setattr(sys, "argv", ["demo.py", "--side", "40", "--out", str(tmp_path / "demo")])
    runpy.run_path(str(script), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    for number, (name, channels) in enumerate([("wall", 1), ("gravel", 1), ("pebbles", 3)]):
        made = tmp_path / "demo" / f"{name}_synth.png"
        assert read_image(tmp_path / "demo" / f"{name}.png").pixels.shape == (channels, 40, 40)
        assert read_image(made).pixels.shape == (channels, 80, 80)
        assert str(made) in lines[number]
        assert any(line.startswith(str(made)) for line in lines[3:])
