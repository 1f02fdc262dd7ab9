"""The benchmark of what is asked of stills, shrunk."""

import json
from pathlib import Path

import bench_guides
import numpy as np
import pytest
import torch
from made import MADE


def test_blobs_are_of_two_kinds_and_others_for_another_seed() -> None:
    one = bench_guides.blobs(64, 0)
    assert set(np.unique(one)) == {0, 1}
    assert 0.1 < one.mean() < 0.9
    assert (one != bench_guides.blobs(64, 1)).any()
    assert np.abs(np.diff(one.astype(int))).mean() < 0.1


def test_a_border_is_1_where_nothing_ends_and_more_where_something_does() -> None:
    noise = torch.rand(3, 60, 60, generator=torch.Generator().manual_seed(0))
    inside = torch.zeros(60, 60, dtype=torch.bool)
    inside[20:40, 20:40] = True
    assert bench_guides.border(noise, inside) == pytest.approx(1, abs=0.1)
    assert bench_guides.border(noise + 2.0 * inside, inside) > 5


def test_what_asks_for_nothing_new_cuts_little() -> None:
    coins = MADE["coins"](96, 16, 0)
    made = bench_guides.kept(coins, 96, 0, "fast")
    assert made["border"] < 3.5
    assert made["cut"] < 0.35


def test_all_is_asked_and_judged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--textures", "coins", "stones", "--sizes", "16", "--side", "80", "--seeds", "1", "--preset", "fast"]
    assert bench_guides.main([*words, "--json", str(tmp_path / "figures.json")]) == 0
    assert "coins and stones 16" in capsys.readouterr().out
    rows = json.loads((tmp_path / "figures.json").read_text())
    assert [row["method"] for row in rows] == ["labels", "tones", "kept"] * 2
    assert all(row["figures"]["followed"] > 0.85 for row in rows[::3])
    assert all(0 <= row["figures"]["cut"] <= 1 for row in rows)
    assert rows[2]["figures"]["followed"] is None
