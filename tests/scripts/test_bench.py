"""The benchmark, shrunk; `cp` stands in for another program."""

import json
import math
import subprocess
from pathlib import Path
from types import ModuleType

import pytest
import torch

from synth import Kind, read_image, write_image


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "scripts"))
    import bench

    copying = bench.Rival("Copy", "cp", lambda cp, exemplar, output, size, seed: [cp, str(exemplar), str(output)])
    failing = bench.Rival("Fail", "false", lambda false, *rest: [false])
    absent = bench.Rival("Absent", "no such program", lambda *rest: [])
    monkeypatch.setattr(bench, "RIVALS", (copying, failing, absent))
    return bench


@pytest.fixture
def textures(tmp_path: Path) -> Path:
    folder = tmp_path / "textures"
    folder.mkdir()
    noise = torch.rand(3, 40, 48, generator=torch.Generator().manual_seed(0))
    write_image(folder / "color.png", noise, Kind("uint8", ("R", "G", "B")))
    write_image(folder / "gray.png", noise[:1], Kind("uint8", ("Y",)))
    (folder / "list.txt").write_text("color\ngray\n")
    return folder


def test_a_list_is_synthesized_and_measured_beside_what_is_there(
    bench: ModuleType, textures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figures = tmp_path / "out", tmp_path / "figures.json"
    words = [
        "--images",
        str(textures),
        "--size",
        "56x48",
        "--preset",
        "fast",
        "--out",
        str(out),
        "--json",
        str(figures),
    ]
    assert bench.main([str(textures / "list.txt"), *words]) == 0
    said = capsys.readouterr()
    assert "Absent is left out" in said.out
    assert said.out.count("Fail failed") == 2
    assert said.err == ""
    rows = {(row["exemplar"], row["method"]): row["figures"] for row in json.loads(figures.read_text())}
    assert set(rows) == {(name, method) for name in ("color", "gray") for method in ("kwatra", "quilting", "Copy")}
    assert rows["gray", "Copy"]["overall"] == pytest.approx(0, abs=1e-6)
    assert rows["color", "kwatra"]["cpu"] > 0
    assert read_image(out / "color_kwatra.png").pixels.shape == (3, 48, 56)
    assert read_image(out / "gray_kwatra.png").pixels.shape == (1, 48, 56)
    # Two lines of an exemplar 48 wide, two outputs 56 wide and a copy 48 wide, 8 pixels apart.
    assert read_image(out / "contact_sheet.png").pixels.shape == (3, 2 * 56, 48 + 56 + 56 + 48 + 32)


def test_the_last_lines_are_means_and_medians(bench: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [bench.Row(str(k), "kwatra", "", dict.fromkeys(bench.FIGURES, k)) for k in (1.0, 2.0, 6.0)]
    assert bench.print_table(iter(rows), bench.FIGURES, 8) == rows
    mean, median = (text.split() for text in capsys.readouterr().out.splitlines()[-2:])
    assert mean == ["mean", "kwatra"] + ["3.000"] * len(bench.FIGURES)
    assert median == ["median", "kwatra"] + ["2.000"] * len(bench.FIGURES)


def test_the_carried_exemplars_are_small_and_some_have_color(bench: ModuleType) -> None:
    exemplars = bench.carried_exemplars()
    assert {image.shape[1:] for image in exemplars.values()} == {(128, 128)}
    assert {image.shape[0] for image in exemplars.values()} == {1, 3}
    assert all(0 <= image.min() < image.max() <= 1 for image in exemplars.values())


def test_the_cost_is_that_of_one_synthesis(bench: ModuleType, textures: Path) -> None:
    cost = bench.cost(read_image(textures / "gray.png").pixels.numpy(), 48, "fast", 0)
    assert cost["cpu per pixel (us)"] == pytest.approx(cost["cpu"] / 48**2 * 1e6)
    assert cost["peak (MiB)"] > 50


def test_a_missing_exemplar_is_named(bench: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench.main(["no_such_texture"]) == 2
    assert capsys.readouterr().err == "bench: no_such_texture.png does not exist; check the name\n"


def test_the_command_for_gmic_names_width_before_height(bench: ModuleType) -> None:
    command = bench.gmic("gmic", Path("in.png"), Path("out.png"), (48, 56), 3)
    assert command[command.index("syntexturize_matchpatch") + 1] == "56,48"


def test_all_that_has_a_price_is_told(
    bench: ModuleType, textures: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import costs

    monkeypatch.setattr(costs, "ROUNDS", 1)
    monkeypatch.setattr(costs, "process", lambda *words: lambda: 100.0)  # seconds, to load torch anew
    monkeypatch.setattr(costs, "by_two_processes", lambda exemplar, side: 1.9)
    words = ["--images", str(textures), "--size", "12x12", "--costs", "--json", str(tmp_path / "costs.json")]
    assert bench.main(["gray", *words, "--out", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "costs.json").read_text())
    assert found["best, times default"] == pytest.approx(found["best 12"] / found["default 12"])
    assert found["fast, 96 times 48"] == pytest.approx(found["fast 96"] / found["fast 48"])
    assert found["quilting, 48 times 24"] == pytest.approx(found["quilting 48"] / found["quilting 24"])
    assert found["command line, more than its synthesis"] == pytest.approx(100 - found["fast 12"])
    assert {"Copy 12", "Copy 48", "default 48", "best 12, times faster by two threads"} <= set(found)
    assert {"default 48, times faster by two threads", "default 12, times faster by two processes"} <= set(found)
    assert math.isnan(found["Fail 12"])
    assert not any(value < 0 for value in found.values())


def test_two_processes_are_timed_by_what_each_makes(bench: ModuleType) -> None:
    import costs

    assert 0.2 < costs.by_two_processes(torch.rand(1, 12, 12), 12) < 5


def test_a_process_is_timed_whole_and_its_failure_is_told(bench: ModuleType) -> None:
    import costs

    assert costs.process("-c", "sum(range(10**7))")() > costs.process("-c", "pass")() > 0
    with pytest.raises(subprocess.CalledProcessError):
        costs.process("-c", "1 / 0")()


def test_figures_are_medians_of_what_is_done_in_turn(bench: ModuleType) -> None:
    import costs

    done = []
    taken = {"a": iter([3.0, 1.0, 2.0]), "b": iter([5.0, 4.0, 9.0])}
    works = {name: lambda name=name: done.append(name) or next(taken[name]) for name in taken}
    assert costs.in_turn(works) == {"a": 2.0, "b": 5.0}
    assert done == ["a", "b"] * costs.ROUNDS
