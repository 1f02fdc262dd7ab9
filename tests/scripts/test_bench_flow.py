"""The benchmark of flowing textures, shrunk."""

import json
import math
from itertools import islice
from pathlib import Path

import bench_flow
import pytest
import tables
import torch
from torch import Tensor

import flow
from synth import Kind, read_flow, read_image, write_image


@pytest.fixture
def noise(tmp_path: Path) -> Path:
    image = torch.rand(1, 48, 40, generator=torch.Generator().manual_seed(0))
    write_image(tmp_path / "noise.png", image, Kind("uint8", ("Y",)))
    return tmp_path / "noise.png"


def test_every_method_is_judged_beside_the_others(noise: Path, tmp_path: Path, capsys) -> None:
    words = ["--size", "40x36", "--fields", "rotation", "--frames", "4", "--at", "1,3", "--short", "2"]
    words += ["--preset", "fast", "--write", str(tmp_path / "frames"), "--json", str(tmp_path / "figures.json")]
    assert bench_flow.main([str(noise), *words]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.count("noise rotation") == len(bench_flow.METHODS)
    rows = {
        (row["exemplar"], row["method"]): row["figures"] for row in json.loads((tmp_path / "figures.json").read_text())
    }
    assert {name for _, name in rows} == set(bench_flow.METHODS)
    ours, thesis = rows["noise rotation", "kwatra"], rows["noise rotation", "thesis"]
    assert set(ours) == set(bench_flow.figure_names([1, 3]))
    assert all(isinstance(value, float) for value in ours.values())
    assert isinstance(thesis["overall@1"], float)
    assert thesis["overall@3"] is None
    assert rows["noise rotation", "independent"]["sharp@3"] is not None
    assert rows["noise rotation", "independent"]["flicker"] > 0.5
    assert rows["noise rotation", "warping"]["sharp@3"] < rows["noise rotation", "kwatra"]["sharp@3"]
    folder = tmp_path / "frames" / "noise_rotation_kwatra"
    assert {path.name for path in folder.iterdir()} == {
        "exemplar.png", "flow.npy", "0000.png", "0001.png", "0002.png", "0003.png",
    }  # fmt: skip
    assert read_image(folder / "0003.png").pixels.shape == (1, 36, 40)
    assert torch.allclose(read_flow(folder / "flow.npy").filled(), flow.rotation()(0, (36, 40)))


def test_every_field_is_flowed_along(noise: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--size", "40x36", "--fields", "rotation", "waves:90", "--frames", "2", "--at", "1", "--preset", "fast"]
    assert bench_flow.main([str(noise), *words, "--methods", "warping"]) == 0
    said = capsys.readouterr().out
    assert said.count("noise rotation") == said.count("noise waves:90") == 1


def test_motion_is_compared_with_the_field_and_with_the_warped_frame() -> None:
    picture = torch.nn.functional.interpolate(torch.rand(1, 1, 24, 24, generator=torch.Generator().manual_seed(0)),
                                              (72, 72), mode="bicubic")[0].clamp(0, 1)  # fmt: skip
    task = bench_flow.Task(picture, flow.uniform(2.0), (72, 72), "fast", 0)
    error, flicker = bench_flow.motion(picture, picture.roll(2, 2), task, 0)
    assert error < 0.15
    assert flicker == 0
    error, flicker = bench_flow.motion(picture, picture, task, 0)
    assert error == pytest.approx(2, abs=0.15)
    expected = (picture - picture.roll(2, 2))[:, 16:-16, 16:-16].abs().mean() / picture.std()
    assert flicker == pytest.approx(float(expected), rel=1e-5)


def test_repeated_warping_warps_what_was_warped() -> None:
    picture = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    a, b, c = islice(bench_flow.warped_frames(bench_flow.Task(picture, flow.uniform(3.0), (40, 48), "fast", 0)), 3)
    assert torch.equal(b[..., 3:], a[..., :-3])
    assert torch.equal(c[..., 6:], a[..., :-6])
    assert torch.equal(c[..., :6], a[..., :1].expand(-1, -1, 6))


def test_what_is_carried_loses_nothing() -> None:
    """Two steps of half a pixel are one of a pixel, to the bit, but for what flows in."""
    picture = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    a, b, c = islice(bench_flow.carried_frames(bench_flow.Task(picture, flow.uniform(0.5), (40, 48), "fast", 0)), 3)
    assert not torch.equal(b, a)
    assert torch.equal(c[..., 2:], a[..., 1:-1])


def test_the_figures_are_multiples_of_the_stills() -> None:
    def figures(image: Tensor) -> dict[str, float]:
        sequence = bench_flow.Sequence({5: image}, [0.1, 0.3], [0.2, 0.2], 1.5, 3.0)
        return bench_flow.figures_of(task, still, sequence, {5: 5}, [5, 9])

    picture = torch.rand(1, 40, 40, generator=torch.Generator().manual_seed(0))
    task = bench_flow.Task(picture, flow.uniform(3.0), (40, 48), "fast", 0)
    still = bench_flow.still_of(task)
    same = figures(still.image)
    assert same["overall@5"] == same["sharp@5"] == 1
    assert same["moved"] > 1
    assert math.isnan(same["overall@9"])
    assert (same["epe"], same["flicker"], same["s/frame"]) == pytest.approx((0.2, 0.2, 1.5))
    assert same["stills"] == pytest.approx(3.0 / still.cpu)
    assert figures(0.5 * still.image)["sharp@5"] == pytest.approx(0.5)


def test_what_cannot_be_done_is_said(noise: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench_flow.main([str(noise), "--fields", "whirl"]) == 2
    assert capsys.readouterr().err.startswith("bench_flow: 'whirl' names no flow; give one of uniform")
    for words in (["--at", "0,3"], ["--frames", "1"], ["--methods", "magic"]):
        with pytest.raises(SystemExit):
            bench_flow.main([str(noise), *words])


def test_figures_that_are_missing_are_left_out_of_the_means() -> None:
    rows = [tables.Row(str(k), "a", "", {"x": value}) for k, value in enumerate((1.0, math.nan, 5.0))]
    rows.append(tables.Row("3", "b", "", {"x": math.nan}))
    found = {(row.exemplar, row.method): row.figures["x"] for row in tables.summaries(rows, ["x"])}
    assert found["mean", "a"] == 3
    assert math.isnan(found["median", "b"])
    assert tables.row_line(rows[3], ["x"], 4).split() == ["3", "b", "-"]
