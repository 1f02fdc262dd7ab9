"""The benchmark of metamorphoses, shrunk."""

import json
from pathlib import Path

import bench_morph
import pytest
import torch

from synth import Kind, read_image, write_image


@pytest.fixture
def pairs(tmp_path: Path) -> Path:
    folder = tmp_path / "pairs" / "noise"
    folder.mkdir(parents=True)
    for seed, name in enumerate("ab"):
        image = torch.rand(3, 40, 36, generator=torch.Generator().manual_seed(seed))
        write_image(folder / f"{name}.png", image, Kind("uint8", ("R", "G", "B")))
    return folder.parent


def test_methods_are_judged_side_by_side(pairs: Path, tmp_path: Path, capsys) -> None:
    words = ["--methods", "blend", "patterns", "control", "control+retexture", "--frames", "3", "--preset", "fast"]
    words += ["--write", str(tmp_path / "films"), "--json", str(tmp_path / "figures.json")]
    assert bench_morph.main([str(pairs), *words]) == 0
    said = capsys.readouterr()
    assert said.err.startswith("noise patterns is left out: found")  # noise has none
    rows = {row["method"]: row["figures"] for row in json.loads((tmp_path / "figures.json").read_text())}
    assert list(rows) == ["blend", "control", "control+retexture"]
    assert set(rows["blend"]) == set(bench_morph.FIGURES)
    assert rows["blend"]["ghost"] == pytest.approx(1, abs=0.02)
    assert rows["control+retexture"]["sharpness"] > rows["blend"]["sharpness"]
    assert all(row["ends"] <= 1 / 255 for row in rows.values())
    assert read_image(tmp_path / "films" / "noise" / "control" / "0002.png").pixels.shape == (3, 40, 36)
    assert read_image(tmp_path / "films" / "noise" / "control.png").pixels.shape == (3, 40, 116)


def test_a_folder_without_pairs_is_refused(tmp_path: Path, capsys) -> None:
    assert bench_morph.main([str(tmp_path)]) == 2
    assert "holds no a.png and b.png" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        bench_morph.main(["--methods", "control+magic"])
    assert "alone or with +retexture" in capsys.readouterr().err
