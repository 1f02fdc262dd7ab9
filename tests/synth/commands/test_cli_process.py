"""The command line as a process: help, modules that are run, pipes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from brick import RGB, texture

from synth import write_image


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with one exemplar in it, brick.png."""
    monkeypatch.chdir(tmp_path)
    write_image("brick.png", texture(), RGB)
    return tmp_path


def python(*arguments: str, **options: object) -> "subprocess.Popen[str]":
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3]), "PYTHONUNBUFFERED": ""}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    return subprocess.Popen([sys.executable, *arguments], **pipes | options)


def test_help_is_quick_because_nothing_heavy_is_imported() -> None:
    program = "import sys; from synth.cli import main\ntry: main(['synth', '--help'])\nexcept SystemExit: pass\n"
    heavy = "print([m for m in ('torch', 'numpy', 'rich', 'PIL', 'faiss', 'synth.commands.merge') if m in sys.modules])"
    before = os.times().children_user
    with python("-c", program + heavy) as process:
        out, _ = process.communicate()
    assert out.endswith("[]\n")
    assert "WIDTHxHEIGHT" in out
    assert os.times().children_user - before < 1  # of work: the clock runs on while others work; it takes a tenth


def test_nothing_is_loaded_that_is_not_used(folder: Path) -> None:
    write_image("brick.png", texture()[:, :24, :24], RGB, overwrite=True)
    program = """
import sys
from synth import cli
cli.main(["synth", "brick.png", "--size", "24", "--preset", "fast"])
cli.main(["fill", "brick.png", "--extend", "4", "--preset", "fast"])  # with features and their transposes
cli.main(["morph", "brick.png", "brick_synth.png", "--method", "control", "--frames", "3", "--preset", "fast"])
idle = ("sympy", "torch.fx.experimental.symbolic_shapes", "torch._dynamo", "scipy.spatial")
print([name for name in idle if name in sys.modules])
"""
    with python("-c", program) as process:
        out, err = process.communicate()
    assert len(list(folder.iterdir())) == 4, err
    assert out.endswith("[]\n")


@pytest.mark.parametrize("name", ["synth", "kwatra"])
def test_a_module_that_is_run_can_speak_before_anything_heavy_is_imported(name: str) -> None:
    with python(
        "-c", f"import sys, {name}\nprint([m for m in ('torch', 'numpy', 'scipy') if m in sys.modules])"
    ) as process:
        out, _ = process.communicate()
    assert out == "[]\n"


@pytest.mark.parametrize("asked", [None, "3"])
def test_threads_of_linear_algebra_are_not_started_unless_they_are_asked_for(
    asked: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    if asked is not None:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", asked)
    seen = "atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS']))"
    with python(
        "-c", f"import atexit, os, sys\n{seen}\nsys.argv = ['kwatra', '--version']\nimport synth.cli\nsynth.cli.entry()"
    ) as process:
        out, err = process.communicate()
    assert out.splitlines()[-1:] == [asked or "1"], err


@pytest.mark.parametrize("name", ["synth", "kwatra"])
def test_runs_as_a_module(name: str) -> None:
    with python("-m", name, "--help") as process:
        out, err = process.communicate()
    assert process.returncode == 0
    assert out.startswith("usage: kwatra ")
    assert err == ""


def test_closed_pipe_is_no_traceback(folder: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with python("-m", "synth", "flow", "rotation", "--size", "8", "-o", "rotation.flo", stdout=writing) as process:
        os.close(writing)
        _, err = process.communicate()
    assert process.returncode == 1
    assert err == ""
