"""The gallery and the benchmark of textures in between, shrunk."""

import json
from pathlib import Path

import bench_patches
import gallery_patches
import pytest
import torch

from synth import Kind, read_image, write_image

SIDE = 36


def test_strips_midpoints_and_maps_come_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shown = {"stones": gallery_patches.pairs(SIDE)["stones"]}
    monkeypatch.setattr(gallery_patches, "pairs", lambda side: shown)
    gallery_patches.main(["--side", str(SIDE), "--only", "5", "film", "--out", str(tmp_path)])
    sizes = {path.stem: tuple(read_image(path).pixels.shape[1:]) for path in tmp_path.iterdir()}
    assert sizes == {"figure_5_stones": (36, 3 * 36 + 16), "figure_film_stones": (36, 6 * 36 + 40)}
    film = read_image(tmp_path / "figure_film_stones.png").pixels
    assert float((film[:, :, :SIDE] - shown["stones"][0]).abs().max()) < 0.01


def test_parts_are_left_out_one_by_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "pairs" / "noise"
    folder.mkdir(parents=True)
    for seed, name in enumerate("ab"):
        image = torch.rand(3, 36, 36, generator=torch.Generator().manual_seed(seed))
        write_image(folder / f"{name}.png", image, Kind("uint8", ("R", "G", "B")))
    words = ["--without", "all", "plain", "--preset", "fast", "--json", str(tmp_path / "figures.json")]
    assert bench_patches.main([str(folder.parent), *words]) == 0
    rows = {row["method"]: row["figures"] for row in json.loads((tmp_path / "figures.json").read_text())}
    assert list(rows) == ["all", "plain"]
    assert rows["plain"]["sharpness"] < rows["all"]["sharpness"]
    assert "all" in capsys.readouterr().out
    assert bench_patches.main([str(tmp_path / "nothing")]) == 2
