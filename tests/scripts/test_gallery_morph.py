"""The gallery of metamorphoses, shrunk: every figure comes out, and shows what it says."""

import itertools
import sys
from pathlib import Path
from typing import Any

import gallery_morph
import pytest

import synth
from synth import read_image

SIDE = 32


def cells(path: Path) -> tuple[int, ...]:
    return tuple((side + 8) // (SIDE + 8) for side in read_image(path).pixels.shape[1:])


def test_the_gallery_makes_every_figure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    morph = synth.morph

    def quickly(*given: Any, **named: Any) -> Any:
        few = {} if named["method"] == "blend" else {"iterations": 2}
        return morph(*given, **{"preset": "fast"} | few | named)

    monkeypatch.setattr(synth, "morph", quickly)
    monkeypatch.setattr(gallery_morph, "TIMES", (0.0, 0.5, 1.0))
    monkeypatch.setattr(sys, "argv", ["gallery_morph.py", "--side", str(SIDE), "--out", str(tmp_path)])
    gallery_morph.main()
    shapes = {path.stem.split("_")[1]: cells(path) for path in tmp_path.iterdir()}
    assert shapes == {
        "4": (2, 4), "5": (2, 3), "7": (6, 3), "8": (2, 5), "9": (3, 3), "12": (4, 3), "13": (2, 3), "14": (2, 4),
        "flowing": (1, 5),
    }  # fmt: skip
    assert all(read_image(path).pixels.std() > 0.02 for path in tmp_path.iterdir())


def test_the_texture_that_turns_into_another_moves_with_the_flow() -> None:
    a, b = gallery_morph.discs(32, 4, 0.3), gallery_morph.discs(32, 4, 0.42, 0.1)
    frames = gallery_morph.flowing(a, b, 4, 2.0)
    for before, after in itertools.pairwise(frames):
        still, moved = (after - before).square().mean(), (after - before.roll(2, 2)).square().mean()
        assert float(moved) < 0.5 * float(still)
    assert float((frames[3].roll(-6, 2) - b).abs().mean()) < 0.5 * float((frames[3] - b).abs().mean())
