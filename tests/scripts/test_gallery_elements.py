"""The gallery of elements, shrunk: every figure comes out, and is a picture of something."""

from pathlib import Path

import gallery_elements
import pytest

from synth import read_image


def test_the_gallery_makes_every_figure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(gallery_elements, "TIMES", (0.0, 1.0))
    gallery_elements.main(["--out", str(tmp_path), "--side", "72"])
    made = sorted(path.stem for path in tmp_path.iterdir())
    assert made == sorted(figure.__name__ for figure in gallery_elements.FIGURES)
    for path in tmp_path.iterdir():
        assert read_image(path).pixels.std() > 0.02
