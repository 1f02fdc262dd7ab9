"""What the tests of the command line share. Each module has a `folder` fixture: the current folder, with its files."""

from collections.abc import Callable
from pathlib import Path

import pytest

from synth.cli import main


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs the command line, which must fail with one sentence and leave the folder as it was; returns the sentence."""

    def run(*arguments: str) -> str:
        before = contents(folder)
        capsys.readouterr()  # of commands run before
        try:
            code = main(arguments)
        except SystemExit as exit:
            code = exit.code
        out, err = capsys.readouterr()
        assert code == 2
        assert out == ""
        assert err.startswith("kwatra: error: ")
        assert err.count("\n") == 1
        assert contents(folder) == before
        return err

    return run
