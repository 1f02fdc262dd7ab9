"""The gallery of flowing textures, shrunk: every figure comes out, and shows what it says."""

import sys
from pathlib import Path
from typing import Any

import gallery_flow
import pytest
import torch

import flow
from synth import read_image
from synth.texture import PRESETS

SIDE = 24
SIZE = 36


@pytest.fixture(autouse=True)
def _few_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    animate, videos = flow.animate, {"renewing": flow.VIDEO_PRESETS["fast"]}
    pictures = {"renewing": flow.PRESETS["fast"], "synthesis": PRESETS["fast"][0]}

    def quickly(exemplar: torch.Tensor, *given: Any, **named: Any) -> Any:
        return animate(exemplar, *given, **(videos if exemplar.ndim == 4 else pictures) | named)

    monkeypatch.setattr(flow, "animate", quickly)
    monkeypatch.setattr(gallery_flow, "KEY_FRAMES", (1, 2, 3))
    monkeypatch.setattr(gallery_flow, "FILLING_FRAMES", (1, 2, 3))
    monkeypatch.setattr(gallery_flow, "VIDEO_FRAMES", 3)
    monkeypatch.setattr(gallery_flow, "VIDEO_FIELDS", gallery_flow.VIDEO_FIELDS[:1])


def test_the_gallery_makes_every_figure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "argv", ["gallery_flow.py", "--side", str(SIDE), "--out", str(tmp_path)])
    gallery_flow.main()
    shapes = {}
    for figure in (29, 30, 31, 32, 33, 34):
        pixels = read_image(tmp_path / f"figure_{figure}.png").pixels
        assert pixels.std() > 0.02
        shapes[figure] = tuple((side + 8) // (SIZE + 8) for side in pixels.shape[1:])
    assert read_image(tmp_path / "figure_36.png").pixels.std() > 0.02
    assert read_image(tmp_path / "section_7.png").pixels.std() > 0.02
    assert shapes == {29: (3, 5), 30: (4, 3), 31: (4, 3), 32: (2, 3), 33: (3, 3), 34: (3, 4)}


def test_one_figure_can_be_made_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "argv", ["gallery_flow.py", "--side", "24", "--only", "32", "--out", str(tmp_path)])
    gallery_flow.main()
    assert [path.name for path in tmp_path.iterdir()] == ["figure_32.png"]


def test_key_frames_are_counted_from_one() -> None:
    frames = gallery_flow.key_frames(gallery_flow.keyboard(SIDE), gallery_flow.FIELDS["sink"], SIZE, (1, 3))
    assert [frame.state.number for frame in frames] == [0, 2]


def test_the_obstacle_is_red_and_what_is_not_yet_filled_blue(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery_flow, "FILLING_FRAMES", (2, 12, 30))
    figure = gallery_flow.figure_33(SIDE)
    red, blue = (
        (figure - torch.tensor(color).view(3, 1, 1)).abs().amax(0) < 1e-6
        for color in (gallery_flow.RED, gallery_flow.BLUE)
    )
    cells = [slice(k * (SIZE + 8), k * (SIZE + 8) + SIZE) for k in range(3)]
    assert len({int(red[row, column].sum()) for row in cells for column in cells}) == 1
    for row in cells:
        empty = [int(blue[row, column].sum()) for column in cells]
        assert empty == sorted(empty, reverse=True)
        assert empty[0] > 2 * empty[2] > 0


def test_keys_differ_and_lie_in_rows() -> None:
    keys = gallery_flow.keyboard(70)
    assert keys.shape == (3, 70, 70)
    assert bool((keys[0, ::10] < 0.2).all())  # gaps between rows of keys 10 px high
    assert not torch.equal(keys[:, 1:9, 1:9], keys[:, 1:9, 11:19])
