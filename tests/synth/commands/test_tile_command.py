"""`kwatra tile`: what it writes, and what it refuses."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from synth import Kind, write_image
from synth.cli import main
from synth.io.images import read_array

RGBA = Kind("uint8", ("R", "G", "B", "A"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder with wall.png, which does not tile, and two maps of it."""
    monkeypatch.chdir(tmp_path)
    noise = torch.rand(1, 4, 18, 22, generator=torch.Generator().manual_seed(0))
    smooth = torch.nn.functional.interpolate(noise, (72, 88), mode="bicubic")[0].clamp(0, 1)
    write_image("wall.png", torch.cat([smooth[:3], smooth[3:].clamp(min=0.5)]), RGBA)
    y, x = torch.meshgrid(torch.arange(72.0), torch.arange(88.0), indexing="ij")
    write_image("rows.tif", y[None], Kind("float32", ("Y",)))
    write_image("columns.tif", x[None], Kind("float32", ("Y",)))
    return tmp_path


def test_the_picture_its_maps_and_where_they_come_from_agree(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--also", "row=rows.tif", "--also", "column=columns.tif", "--map", "map.npy", "--band", "12"]
    assert main(["tile", "wall.png", *options]) == 0
    out, _ = capsys.readouterr()
    assert out.startswith("wrote wall_tile.png, wall_tile_row.tif, wall_tile_column.tif and map.npy: 88x72, ")
    wall, kind = read_array("wall.png")
    tiled, same = read_array("wall_tile.png")
    assert same == kind
    assert np.array_equal(tiled[12:-12, 12:-12], wall[12:-12, 12:-12])
    rows, columns = (read_array(f"wall_tile_{name}.tif")[0][..., 0].astype(int) for name in ("row", "column"))
    assert np.array_equal(np.load("map.npy"), np.stack([0 * rows, rows, columns]))
    copied = (wall[rows, columns] == tiled).all(-1)
    assert copied.mean() > 0.4  # the smooth rest was blended
    moved = (rows != np.arange(72)[:, None]) | (columns != np.arange(88))
    assert f"{(tiled != wall).any(-1).mean():.0%} of it changed" in out
    assert 0.05 < moved.mean() < 0.6


def test_a_texture_that_repeats_is_cropped_when_asked_and_hinted_at_else(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    y, x = np.mgrid[:70, :92]
    dots = (np.hypot(y % 16 - 8, x % 20 - 10) < 5).astype(np.float32)
    write_image("dots.png", torch.from_numpy(dots)[None], Kind("uint8", ("Y",)))
    assert main(["tile", "dots.png"]) == 0
    assert "80x64 holds whole periods; --crop cuts the picture to that" in capsys.readouterr().err
    assert main(["tile", "dots.png", "--crop", "-o", "cropped.png"]) == 0
    out, err = capsys.readouterr()
    assert "80x64" in out
    assert err == ""
    cropped = read_array("cropped.png")[0]
    assert np.array_equal(np.roll(cropped, (16, 20), (0, 1)), cropped)


def test_what_cannot_be_done_is_refused(folder: Path, refused: Callable[..., str]) -> None:
    assert "the band is 60 pixels" in refused("tile", "wall.png", "--band", "60")
    assert "no period was found" in refused("tile", "wall.png", "--crop")
    assert "write NAME=FILE" in refused("tile", "wall.png", "--also", "rows.tif")
    assert "would be written twice" in refused("tile", "wall.png", "-o", "a.png", "--map", "a.png")
