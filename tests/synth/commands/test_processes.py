"""The command line as a process: Ctrl-C at any time, streams that cannot show a name, other people's folders."""

import io
import os
import signal
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import torch

from synth import Kind, write_image
from synth.cli import main

ROOT = str(Path(__file__).parents[3])
FAST = ["synth", "brick.png", "--preset", "fast", "--size", "24x24"]
QUICK = ["quilt", "brick.png", "--refine", "0", "--size", "24x24"]

PROGRAM = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from synth import cli

rung, swallowed = sys.argv[1].removeprefix("swallowed:"), sys.argv[1].startswith("swallowed:")

class Bell:
    def find_spec(self, name, *rest):
        if name == rung:
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                if not swallowed:
                    raise

sys.meta_path.insert(0, Bell())
sys.argv = ["kwatra", *sys.argv[2:]]
sys.exit(cli.main())
"""


@pytest.fixture(autouse=True)
def _heeds_ctrl_c() -> Iterator[None]:
    """Ctrl-C means what it does in a terminal, though a shell that runs the tests in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_image("brick.png", torch.rand(1, 24, 24, generator=torch.Generator().manual_seed(0)), Kind("uint8", ("Y",)))
    return tmp_path


def python(*arguments: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": ROOT} | environment,
    )


@pytest.mark.parametrize(
    "module",
    ["argparse", "synth.commands.synth", "torch._C", "torch.nn.functional", "swallowed:scipy"],
)
def test_ctrl_c_while_modules_load(folder: Path, module: str) -> None:
    done = python("-c", PROGRAM, module, *FAST)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "kwatra: interrupted, nothing was written\n")
    assert os.listdir() == ["brick.png"]


def test_ctrl_c_while_the_program_is_looked_for(folder: Path) -> None:
    """`python -m kwatra`, before its command line is known."""
    looking = "import runpy, signal, importlib.metadata as metadata\n"
    looking += "metadata.entry_points = lambda **_: signal.raise_signal(signal.SIGINT)\n"
    looking += "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    done = python("-c", looking + "runpy.run_module('kwatra', run_name='__main__')", *FAST)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "kwatra: interrupted, nothing was written\n")


def test_ctrl_c_in_the_middle(folder: Path, monkeypatch, capsys) -> None:
    @contextmanager
    def rings(title: str) -> Iterator[Callable[[object], None]]:
        yield lambda progress: signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("synth.commands.synth.progress_line", rings)
    assert main([*FAST, "--progress-images", "levels"]) == 130
    assert capsys.readouterr() == ("", "kwatra: interrupted, nothing was written\n")
    assert os.listdir() == ["brick.png"]


def test_ctrl_c_that_a_library_turns_into_an_error_of_its_own(folder: Path, monkeypatch, capsys) -> None:
    def load(*_: object, **__: object) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr("synth.texture.images.synthesize", load)
    assert main(FAST) == 130
    assert capsys.readouterr().err == "kwatra: interrupted, nothing was written\n"


def test_ctrl_c_when_the_files_are_in_place_comes_too_late(folder: Path, monkeypatch, capsys) -> None:
    moved = os.replace

    def replace(source: Path, target: Path) -> None:
        moved(source, target)
        signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(os, "replace", replace)
    assert main([*FAST, "--map", "m.npy"]) == 0
    assert capsys.readouterr().out.startswith("wrote brick_synth.png and m.npy: 24x24, seed 0, in ")
    assert Path("m.npy").exists()
    assert signal.getsignal(signal.SIGINT) is before


def test_names_that_an_ascii_stream_cannot_show(folder: Path, monkeypatch) -> None:
    for name, code, said in (("stdout", 0, "wrote {}: 24x24, seed 0, in "), ("stderr", 2, "kwatra: error: {} exists")):
        stream = io.TextIOWrapper(io.BytesIO(), "ascii", "strict")
        monkeypatch.setattr(sys, name, stream)
        assert main([*QUICK, "-o", "wände\udcff.png"]) == code
        stream.seek(0)
        assert stream.read().startswith(said.format("w\\xe4nde\\udcff.png"))


def test_a_closed_stdout_is_no_error(folder: Path) -> None:
    command = f"exec {sys.executable} -m synth flow rotation --size 8 -o rotation.flo >&-"
    done = subprocess.run(command, shell=True, stderr=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": ROOT})
    assert (done.returncode, done.stderr) == (0, "")
    assert Path("rotation.flo").exists()


@pytest.mark.parametrize("name", ["flow", "kwatra"])
def test_a_folder_of_a_users_own_that_stands_before_ours(folder: Path, name: str) -> None:
    (folder / name).mkdir()
    (folder / name / "__init__.py").touch()
    program = f"import sys; sys.path[:0] = [{ROOT!r}]; import synth; sys.path[:0] = ['']; "
    done = python("-c", f"{program}from synth.cli import main; sys.exit(main({FAST!r}))", PYTHONPATH="")
    assert done.returncode == 2
    assert done.stderr.startswith(f"kwatra: error: python finds {folder / name} as the package {name}, not ")
    assert done.stderr.count("\n") == 1
    done = python("-c", f"{program}synth.read_flow", PYTHONPATH="")
    assert f"ImportError: python finds {folder / name} as the package {name}, not " in done.stderr


def test_a_library_that_is_missing_is_no_damage_of_the_file(folder: Path, monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "imagecodecs", None)
    assert main(FAST) == 2
    error = capsys.readouterr().err
    assert error.startswith("kwatra: error: a library could not be loaded (import of imagecodecs halted")
    assert error.count("\n") == 1


def test_warnings_of_libpng_reach_nobody(folder: Path) -> None:
    data = Path("brick.png").read_bytes()
    chunk = b"sBIT\x09"  # nine of eight bits
    odd = struct.pack(">I", 1) + chunk + struct.pack(">I", zlib.crc32(chunk))
    Path("odd.png").write_bytes(data[:33] + odd + data[33:])
    done = python("-m", "synth", "quilt", "odd.png", *QUICK[2:])
    assert (done.returncode, done.stderr) == (0, "")
