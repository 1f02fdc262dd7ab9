"""`kwatra flow`: what it writes, and what it refuses."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

import flow
from synth import read_flow, read_image, write_flow
from synth.cli import main


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a flow in it of which two vectors are not known, wind.flo."""
    monkeypatch.chdir(tmp_path)
    known = torch.ones(30, 40, dtype=torch.bool)
    known[3, 4] = known[9, 9] = False
    write_flow("wind.flo", flow.rotation(1.5)(0.0, (30, 40)), known)
    return tmp_path


def test_a_named_field_becomes_a_file_and_a_picture(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["flow", "sink", "-o", "sink.flo", "--picture", "sink.png", "--size", "64x48", "--speed", "3"]) == 0
    assert torch.equal(read_flow("sink.flo").flow, flow.sink(3)(0.0, (48, 64)))
    drawn = flow.picture(flow.sink(3)(0.0, (48, 64)), arrows=16)
    assert torch.allclose(read_image("sink.png").pixels, drawn, atol=0.003)
    assert capsys.readouterr().out == "wrote sink.flo and sink.png: 64x48, up to 3 px per frame\n"


def test_a_folder_takes_the_field_by_its_name(folder: Path) -> None:
    Path("fields").mkdir()
    assert main(["flow", "uniform:90", "-o", "fields/", "--size", "16"]) == 0
    assert torch.equal(read_flow("fields/uniform90.flo").flow, flow.uniform(2.0, angle=90)(0.0, (16, 16)))


def test_a_file_is_converted_with_what_is_unknown(folder: Path) -> None:
    assert main(["flow", "wind.flo", "-o", "wind.npz"]) == 0
    before, after = read_flow("wind.flo"), read_flow("wind.npz")
    assert torch.equal(before.flow, after.flow)
    assert torch.equal(before.known, after.known)


def test_a_file_is_filled_where_it_is_stretched(folder: Path) -> None:
    assert main(["flow", "wind.flo", "-o", "large.npy", "--size", "80x60"]) == 0
    large = read_flow("large.npy")
    assert bool(large.known.all())
    assert torch.allclose(large.flow, flow.resampled(read_flow("wind.flo").filled(), (60, 80)))


def test_fields_in_time(folder: Path) -> None:
    assert main(["flow", "waves:30", "-o", "waves.npz", "--size", "40x30", "--frames", "4"]) == 0
    assert read_flow("waves.npz").flow.shape == (4, 2, 30, 40)
    assert main(["flow", "waves.npz", "-o", "faster.npy", "--speed", "4"]) == 0
    assert np.isclose(np.linalg.norm(np.load("faster.npy"), axis=1).max(), 4)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["snik", "-o", "a.flo"], "'snik' names no flow; give one of uniform, rotation"),
        (["snik"], "'snik' names no flow; give one of uniform, rotation"),
        (["sink"], "there is nothing to write"),
        (["sink", "-o", "wind.flo"], "wind.flo exists; name another file or allow it with --overwrite"),
        (["sink", "-o", "a.mp4"], "a.mp4 has an ending that no flow file has"),
        (["sink", "--picture", "a.flo"], "a.flo has an ending that cannot hold uint8 RGB pixels"),
        (["sink", "-o", "a.png", "--picture", "a.png"], "a.png would be written twice"),
        (["waves", "-o", "a.flo", "--frames", "2"], "a.flo cannot hold a flow in time"),
        (["sink", "-o", "a.flo", "--speed", "500"], "beyond the 256x256 frame; give a lower speed"),
        (["sink", "-o", "a.flo", "--speed", "nan"], "'nan' is no finite number"),
        (["sink", "-o", "a.flo", "--size", "0x9"], "'0x9' is no size; write WIDTHxHEIGHT"),
        (["sink", "-o", "a.flo", "--size", "99999x9999"], "a size of 99999x9999 is too large; ask for at most"),
        (["gone.flo", "-o", "a.flo"], "gone.flo does not exist"),
    ],
)
def test_bad_input_costs_a_sentence(folder: Path, refused: Callable[..., str], arguments: list[str], sentence: str):
    assert sentence in refused("flow", *arguments)
