"""Normal maps from the command line: `--also normal=...` of synth, quilt and videos turns with the pieces."""

from pathlib import Path

import numpy as np
import pytest

from synth.cli import main
from synth.io.images import array_writer, read_array
from synth.io.kinds import Kind
from synth.io.outputs import write_files

KINDS = {1: Kind("uint8", ("Y",)), 3: Kind("uint8", ("R", "G", "B"))}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A current folder with arrows.png, whose normals.png points right everywhere but for one row of y."""
    monkeypatch.chdir(tmp_path)
    image = np.random.default_rng(0).integers(0, 256, (40, 40, 1), np.uint8)
    normals = np.full((40, 40, 3), (255, 127, 90), np.uint8)
    write_files({Path(name): array_writer(Path(name), array, KINDS[array.shape[2]])
                 for name, array in (("arrows.png", image), ("normals.png", normals))}, overwrite=False)  # fmt: skip
    return tmp_path


@pytest.mark.parametrize(
    "command",
    ["synth arrows.png --preset fast --rotate=90", "quilt arrows.png --refine 4 --rotate=90"],
)
def test_what_pointed_right_points_where_its_piece_was_turned_to(folder: Path, command: str) -> None:
    words = [*command.split(), "--size", "96x96", "--also", "normal=normals.png", "--also", "other=normals.png"]
    assert main([*words, "-o", "out.png", "--map", "where.npy"]) == 0
    turned, other = read_array(Path("out_normal.png"))[0], read_array(Path("out_other.png"))[0]
    assert {tuple(pixel) for pixel in other.reshape(-1, 3)} == {(255, 127, 90)}
    directions = {tuple(pixel) for pixel in turned.reshape(-1, 3)}
    assert len(directions) == 2
    assert directions <= {(255, 127, 90), (127, 255, 90), (128, 255, 90)}  # turned counterclockwise they point up
    assert main(["synth", "normals.png", "--apply", "where.npy", "-o", "later.png"]) == 0
    assert Path("later.png").read_bytes() == Path("out_normal.png").read_bytes()
