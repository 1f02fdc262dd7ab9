"""The quilting gallery, shrunk: every figure comes out, and is a picture of something."""

import sys
from pathlib import Path

import pytest

from synth import read_image
from synth.io.videos import read_video


def test_the_gallery_makes_every_figure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "scripts"))
    import gallery_quilting

    monkeypatch.setattr(sys, "argv", ["gallery_quilting.py", "--side", "24", "--out", str(tmp_path)])
    gallery_quilting.main()
    for figure in (4, 8, 9, 10, 11, 12, 15):
        assert read_image(tmp_path / f"figure_{figure}.png").pixels.std() > 0.02
    for name in ("loop", "time", "spacetime"):
        assert read_video(tmp_path / f"figure_16_{name}.gif").frames.shape[1] == 48
