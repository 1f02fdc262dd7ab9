"""Files are written whole or not at all."""

from pathlib import Path

import pytest

from synth.io.outputs import write_files


def test_several_files_are_written_all_or_none(tmp_path: Path) -> None:
    def broken(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_files({tmp_path / "a.txt": lambda path: path.write_text("whole"), tmp_path / "b.txt": broken})
    assert not list(tmp_path.iterdir())
