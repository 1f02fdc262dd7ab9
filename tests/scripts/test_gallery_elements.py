"""The gallery of elements, shrunk: every figure comes out, and is a picture of something."""

from pathlib import Path

import gallery_elements
import pytest

from synth import read_image


def test_the_gallery_makes_every_figure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    figures, slow = gallery_elements.FIGURES, gallery_elements.tonietto_walter_9_published
    monkeypatch.setattr(gallery_elements, "TIMES", (0.0, 1.0))
    for some, side in ((tuple(figure for figure in figures if figure is not slow), 72), ((slow,), 36)):
        monkeypatch.setattr(gallery_elements, "FIGURES", some)
        gallery_elements.main(["--out", str(tmp_path), "--side", str(side)])
    assert sorted(path.stem for path in tmp_path.iterdir()) == sorted(figure.__name__ for figure in figures)
    for path in tmp_path.iterdir():
        assert read_image(path).pixels.std() > 0.02
