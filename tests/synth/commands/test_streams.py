"""`-`: images from standard input and to standard output."""

import io
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from synth import Kind, write_image
from synth.cli import main
from synth.io import streams
from synth.io.images import read_array

FAST = ["--preset", "fast", "--size", "40x32"]


class Stream(io.TextIOWrapper):
    """A text stream over bytes that can be looked at."""

    def __init__(self, data: bytes = b"", terminal: bool = False) -> None:
        self.bytes = io.BytesIO(data)
        self.terminal = terminal
        super().__init__(self.bytes, encoding="utf-8")

    def isatty(self) -> bool:
        return self.terminal


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    streams.standard_input.cache_clear()
    generator = torch.Generator().manual_seed(0)
    write_image("a.png", torch.rand(3, 24, 24, generator=generator), Kind("uint8", ("R", "G", "B")))
    write_image("f.tif", torch.rand(1, 24, 24, generator=generator), Kind("float32", ("Y",)))
    yield tmp_path
    streams.standard_input.cache_clear()


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("f.tif", b"II*\0")])
def test_an_image_passes_through(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, start: bytes
) -> None:
    assert main(["synth", name, "-o", f"file{name[1:]}", *FAST]) == 0
    sent = Stream()
    with monkeypatch.context() as streams_of_ours:
        streams_of_ours.setattr(sys, "stdin", Stream(Path(name).read_bytes()))
        streams_of_ours.setattr(sys, "stdout", sent)
        assert main(["synth", "-", *FAST]) == 0
    assert sent.bytes.getvalue().startswith(start)
    Path(f"sent{name[1:]}").write_bytes(sent.bytes.getvalue())
    assert np.array_equal(read_array(f"sent{name[1:]}")[0], read_array(f"file{name[1:]}")[0])
    assert capsys.readouterr().err.startswith("wrote -: 40x32, seed 0, in ")
    assert not Path("-").exists()


def test_other_files_are_written_beside_a_stream(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sent = Stream()
    with monkeypatch.context() as ours:
        ours.setattr(sys, "stdout", sent)
        assert main(["tile", "a.png", "-o", "-", "--map", "m.npy"]) == 0
    assert np.load("m.npy").shape == (3, 24, 24)
    assert sent.bytes.getvalue().startswith(b"\x89PNG")


def test_what_cannot_be_piped_is_refused(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "a recipe cannot say what came or went by -" in refused(
        "synth", "a.png", "-o", "-", "--save-recipe", "r.toml"
    )
    assert "--also writes beside the output, which is a stream" in refused(
        "synth", "a.png", "-o", "-", "--also", "n=a.png"
    )
    with monkeypatch.context() as ours:
        ours.setattr(sys, "stdin", Stream(terminal=True))
        assert "- stands for an image on standard input, but there is none" in refused("synth", "-", "-o", "x.png")
        ours.setattr(sys, "stdin", Stream(b"no image at all"))
        assert "standard input is not a PNG" in refused("synth", "-", "-o", "x.png")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    assert "standard output, which is a terminal" in refused("synth", "a.png", "-o", "-")


def test_a_process_leaves_nothing_of_its_standard_input(folder: Path) -> None:
    Path("temporary").mkdir()
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3]), "TMPDIR": str(folder / "temporary")}
    done = subprocess.run([sys.executable, "-m", "synth", "synth", "-", *FAST], input=Path("a.png").read_bytes(),
                          capture_output=True, env=environment, check=True)  # fmt: skip
    assert done.stdout.startswith(b"\x89PNG")
    assert done.stderr.startswith(b"wrote -: 40x32")
    assert not [path for path in Path("temporary").iterdir() if path.name.startswith("standard-input")]


@pytest.mark.parametrize(("command", "output"), [("synth", "made.png"), ("animate", "made.mp4")])
def test_there_may_be_no_stderr(folder: Path, command: str, output: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", None)
    more = ["--flow", "sink", "--frames", "2"] if command == "animate" else []
    assert main([command, "a.png", "-o", output, *FAST, *more]) == 0
    assert Path(output).is_file()


@pytest.mark.parametrize("words", [["tile", "a.png", "-o", "-", "--map", "m.npy"], ["flow", "sink", "-o", "f.flo"]])
def test_nothing_is_said_where_whoever_reads_has_gone(folder: Path, words: list[str]) -> None:
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    read, write = os.pipe()
    os.close(read)
    try:
        done = subprocess.run([sys.executable, "-m", "synth", *words], stdout=write, stderr=subprocess.PIPE,
                              env=environment)  # fmt: skip
    finally:
        os.close(write)
    assert (done.returncode, done.stderr) == (1, b"")
    assert not Path("m.npy").exists()
    assert not list(folder.glob(".kwatra*"))
