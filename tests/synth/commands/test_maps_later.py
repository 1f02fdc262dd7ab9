"""Maps carried by quilt and fill, several exemplars in quilt, and source maps applied later."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from textures import noise

from synth import Kind, write_image
from synth.cli import main
from synth.io.images import read_array, read_values

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))
FAST = ["--preset", "fast"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two exemplars, for each a map of numbers that no other pixel has, and a hole."""
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise(3, 24, 32, seed=0), RGB)
    write_image("b.png", noise(3, 30, 20, seed=1), RGB)
    tifffile.imwrite("a.tif", np.arange(24 * 32, dtype=np.uint32).reshape(24, 32))
    tifffile.imwrite("b.tif", 1000 + np.arange(30 * 20, dtype=np.uint32).reshape(30, 20))
    hole = torch.zeros(1, 24, 32)
    hole[:, 8:16, 10:20] = 1
    write_image("hole.png", hole, GRAY)
    return tmp_path


@pytest.mark.parametrize("options", [[], ["--rotate=90,180", "--mirror"]])
def test_a_quilts_map_goes_along_exactly(folder: Path, options: list[str]) -> None:
    command = ["quilt", "a.png", "--also", "id=a.tif", "--map", "m.npy", "--refine", "2", *options]
    assert main(command) == 0
    number, row, column = np.load("m.npy")[:3]
    assert not number.any()
    assert np.array_equal(read_values("a_quilt_id.tif")[0][..., 0], read_values("a.tif")[0][row, column, 0])
    assert np.array_equal(read_array("a_quilt.png")[0], read_array("a.png")[0][row, column])


def test_scaled_patches_come_from_where_they_show(folder: Path) -> None:
    y, x = torch.meshgrid(torch.linspace(0, 1, 48), torch.linspace(0, 1, 40), indexing="ij")
    write_image("ramp.png", torch.stack([y, x, 0.5 * (x + y)]), Kind("uint16", ("R", "G", "B")))
    assert main(["quilt", "ramp.png", "--scale", "0.7,1.4", "--map", "m.npy", "--refine", "2"]) == 0
    _, row, column = np.load("m.npy")
    differing = np.abs(read_array("ramp_quilt.png")[0].astype(int) - read_array("ramp.png")[0][row, column])
    assert np.median(differing) < 65535 / 40


def test_several_exemplars_are_quilted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--also", "id=a.tif,b.tif", "--map", "m.npy", "--refine", "2", "--size", "80x80"]
    assert main(["quilt", "a.png", "b.png", *options]) == 0
    source = np.load("m.npy")
    assert set(np.unique(source[0])) == {0, 1}
    ids = read_values("a_quilt_id.tif")[0][..., 0]
    assert np.array_equal(ids >= 1000, source[0] == 1)
    pictures = [read_array(f"{name}.png")[0] for name in "ab"]
    made = read_array("a_quilt.png")[0]
    for number, picture in enumerate(pictures):
        here = source[0] == number
        assert np.array_equal(made[here], picture[source[1][here], source[2][here]])
    assert f"; of it a.png {(source[0] == 0).mean():.0%}, b.png " in capsys.readouterr().out


def test_a_fillings_map_is_filled_likewise(folder: Path) -> None:
    options = ["--extend", "8,4,0,0", "--also", "id=a.tif", "--map", "m.npy"]
    assert main(["fill", "a.png", "--hole", "hole.png", *options, *FAST]) == 0
    source, ids = np.load("m.npy"), read_values("a.tif")[0][..., 0]
    assert source.shape == (3, 28, 40)
    filled = read_values("a_fill_id.tif")[0][..., 0]
    assert np.array_equal(filled, ids[source[1], source[2]])
    known = read_array("hole.png")[0][..., 0] == 0
    assert np.array_equal(filled[4:, 8:][known], ids[known])
    assert known[source[1], source[2]].all()


def test_a_filling_from_others_takes_their_maps(folder: Path) -> None:
    options = ["--exemplar", "b.png", "--also", "id=a.tif,b.tif"]
    assert main(["fill", "a.png", "--hole", "hole.png", *options, *FAST]) == 0
    filled, hole = read_values("a_fill_id.tif")[0][..., 0], read_array("hole.png")[0][..., 0] > 0
    assert filled[hole].min() >= 1000
    assert np.array_equal(filled[~hole], read_values("a.tif")[0][..., 0][~hole])


@pytest.mark.parametrize("name", ["m.npy", "m.png"])
def test_a_map_that_comes_later_is_rearranged_as_one_that_was_there(folder: Path, name: str) -> None:
    options = ["--also", "id=a.tif", "--map", name, "--mirror"]
    assert main(["synth", "a.png", *options, *FAST]) == 0
    assert main(["synth", "a.tif", "--apply", name, "-o", "later.tif"]) == 0
    assert np.array_equal(read_values("later.tif")[0], read_values("a_synth_id.tif")[0])


def test_maps_of_tiles_quilts_and_several_exemplars_are_applied(folder: Path) -> None:
    assert main(["quilt", "a.png", "b.png", "--also", "id=a.tif,b.tif", "--map", "m.npy", "--refine", "1"]) == 0
    assert main(["synth", "a.tif", "b.tif", "--apply", "m.npy", "-o", "later.tif"]) == 0
    assert np.array_equal(read_values("later.tif")[0], read_values("a_quilt_id.tif")[0])
    assert main(["tile", "a.png", "--also", "id=a.tif", "--map", "t.npy"]) == 0
    assert main(["synth", "a.tif", "--apply", "t.npy", "-o", "tile.tif"]) == 0
    assert np.array_equal(read_values("tile.tif")[0], read_values("a_tile_id.tif")[0])


def test_what_cannot_be_applied_is_refused(folder: Path, refused: Callable[..., str]) -> None:
    np.save("two.npy", np.ones((3, 4, 4), np.int32))
    np.save("far.npy", np.stack([np.zeros((4, 4)), np.full((4, 4), 40), np.full((4, 4), 3)]).astype(np.int32))
    np.save("odd.npy", np.zeros((2, 4, 4)))
    assert "two.npy is of 2 images but 1 given" in refused("synth", "a.png", "--apply", "two.npy")
    assert "far.npy takes pixels from 4x41 or more but a.png is 32x24" in refused(
        "synth", "a.png", "--apply", "far.npy"
    )
    assert "none.npy does not exist; check the name" in refused("synth", "a.png", "--apply", "none.npy")
    assert "odd.npy holds float64 of shape (2, 4, 4)" in refused("synth", "a.png", "--apply", "odd.npy")
    assert "hole.png holds uint8 Y; a map of where" in refused("synth", "a.png", "--apply", "hole.png")
    for option in ("--seed=3", "--tile", "--preset=best", "--size=9", "--mirror"):
        message = refused("synth", "a.png", "--apply", "two.npy", option)
        assert f"{option.split('=')[0]} is for what is synthesized but --apply only rearranges" in message


def test_videos_take_no_maps_and_come_alone(folder: Path, refused: Callable[..., str]) -> None:
    Path("clip").mkdir()
    for number in range(3):
        write_image(f"clip/{number}.png", noise(3, 12, 12, seed=number), RGB)
    assert "--also is for images but clip is a video" in refused("quilt", "clip", "-o", "out", "--also", "n=a.tif")
    assert "clip is a video, of which only one is quilted" in refused("quilt", "a.png", "clip", "-o", "out")
