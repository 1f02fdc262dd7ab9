"""The command line: what it writes."""

import csv
import gc
import json
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from brick import QUICK, RGB, texture
from PIL import Image

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.io.images import read_array, read_values
from synth.io.videos import write_video


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with one exemplar in it, brick.png."""
    monkeypatch.chdir(tmp_path)
    write_image("brick.png", texture(), RGB)
    return tmp_path


def test_output_goes_to_the_current_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["synth", "brick.png", "--preset", "fast"]) == 0
    picture = read_image("brick_synth.png")
    assert picture.kind == RGB
    assert picture.pixels.shape == (3, 128, 128)
    out, err = capsys.readouterr()
    assert out.startswith("wrote brick_synth.png: 128x128, seed 0, in ")
    assert out.endswith(" (0 is best)\n")
    assert float(out.split("quality about ")[1].split()[0]) < 0.3
    assert out.count("\n") == 1
    assert err == ""


def test_garbage_is_looked_for_again_once_all_is_loaded(folder: Path) -> None:
    gc.disable()  # as a process of the command line begins
    try:
        assert main(["synth", "brick.png", *QUICK]) == 0
        assert gc.isenabled()
    finally:
        gc.unfreeze()
        gc.enable()


def test_size_is_width_by_height_and_the_seed_decides(folder: Path) -> None:
    for seed, name in ((1, "a"), (1, "b"), (2, "c")):
        assert main(["synth", "brick.png", "-o", f"{name}.png", "--seed", str(seed), *QUICK]) == 0
    a, b, c = (read_image(f"{name}.png").pixels for name in "abc")
    assert a.shape == (3, 48, 64)
    assert torch.equal(a, b)
    assert not torch.equal(a, c)


@pytest.mark.parametrize(
    ("suffix", "kind"),
    [
        (".png", Kind("uint8", ("Y",))),
        (".png", Kind("uint16", ("R", "G", "B", "A"))),
        (".jpg", RGB),
        (".tif", Kind("uint16", ("R", "G", "B"))),
        (".tif", Kind("float32", ("Y", "X1", "X2", "X3", "X4"))),
        (".exr", Kind("float16", ("R", "G", "B"))),
    ],
)
def test_comes_out_as_it_went_in(folder: Path, suffix: str, kind: Kind) -> None:
    scale = 7.0 if kind.dtype.startswith("f") else 1.0
    write_image(f"in{suffix}", texture(len(kind.channels)) * scale, kind)
    assert main(["synth", f"in{suffix}", *QUICK]) == 0
    source, made = read_image(f"in{suffix}"), read_image(f"in_synth{suffix}")
    assert made.kind == kind
    assert made.pixels.shape == (len(kind.channels), 48, 64)
    assert abs(float(made.pixels.mean() - source.pixels.mean())) < 0.1 * scale


def test_progress_images_have_the_values_of_the_exemplar(folder: Path) -> None:
    write_image("in.tif", texture() * 7 - 2, Kind("float32", RGB.channels))
    assert main(["synth", "in.tif", *QUICK, "--levels", "1:8", "--progress-images", "levels"]) == 0
    stage, made = read_image("levels/level_1_scale1_width8.tif"), read_image("in_synth.tif")
    assert torch.allclose(stage.pixels, made.pixels, atol=1.0)
    assert abs(float((stage.pixels - made.pixels).mean())) < 0.1


def test_everything_at_once(folder: Path) -> None:
    write_image("other.png", texture(seed=1), RGB)
    arguments = "--tile --mirror --rotate=-90,90 --scale 0.8 --levels 2:16,1:8 --threads 1 --map m.npy"
    command = ["synth", "brick.png", "other.png", "-o", "out.png", *QUICK, *arguments.split()]
    assert main([*command, "--progress-images", "levels", "--energy", "e.csv"]) == 0
    assert main(["synth", "brick.png", "-o", "plain.png", *QUICK, "--energy", "e.png"]) == 0
    with Path("e.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["level"] for row in rows] == sorted(row["level"] for row in rows)
    assert all(float(row["total"]) >= 0 for row in rows)
    with Image.open("e.png") as image:
        assert image.size == (960, 480)
    stages = sorted(path.name for path in Path("levels").iterdir())
    assert stages == ["level_1_scale2_width16.png", "level_2_scale1_width8.png"]
    assert read_image("levels/level_2_scale1_width8.png").pixels.shape == (3, 48, 64)
    assert main([*command, "--progress-images", "levels", "--overwrite"]) == 0  # a folder that is there is used
    source = np.load("m.npy")
    assert source.dtype == np.int32
    assert source.shape == (4, 48, 64)  # the fourth row: how mirrored variants lie
    assert set(np.unique(source[0])) <= {0, 1}
    assert source.min() >= 0
    assert source[1:3].max() < 64


def test_maps_are_carried_exactly(folder: Path) -> None:
    generator = np.random.default_rng(0)
    normal = generator.integers(0, 65535, (64, 64, 3), np.uint16)
    identity = np.arange(64 * 64, dtype=np.uint32).reshape(64, 64)
    write_image(
        "brick_n.png",
        torch.from_numpy(normal.astype(np.float32) / 65535).permute(2, 0, 1),
        Kind("uint16", RGB.channels),
    )
    tifffile.imwrite("ids.tif", identity)
    also = ["--also", "normal=brick_n.png", "--also", "id=ids.tif", "--map", "m.png"]
    assert main(["synth", "brick.png", *QUICK, *also]) == 0
    source = read_array("m.png")[0]
    columns, rows, images = source[..., 0], source[..., 1], source[..., 2]
    assert not images.any()
    np.testing.assert_array_equal(read_array("brick_synth_normal.png")[0], normal[rows, columns])
    np.testing.assert_array_equal(read_values("brick_synth_id.tif")[0][..., 0], identity[rows, columns])


def test_several_exemplars_have_a_map_each(folder: Path) -> None:
    write_image("other.png", texture(size=(48, 80), seed=1), RGB)
    write_image("brick_h.png", torch.zeros(1, 64, 64), Kind("uint8", ("Y",)))
    write_image("other_h.png", torch.ones(1, 48, 80), Kind("uint8", ("Y",)))
    also = ["--also", "height=brick_h.png,other_h.png", "--map", "m.npy"]
    assert main(["synth", "brick.png", "other.png", *QUICK, *also]) == 0
    np.testing.assert_array_equal(read_array("brick_synth_height.png")[0][..., 0], np.load("m.npy")[0] * 255)


def test_start_image_gives_the_size(folder: Path) -> None:
    write_image("start.png", texture(size=(50, 70), seed=3), RGB)
    assert main(["synth", "brick.png", "--preset", "fast", "--start", "start.png"]) == 0
    assert read_image("brick_synth.png").pixels.shape == (3, 50, 70)


def test_constant_color_gives_that_color(folder: Path) -> None:
    write_image("flat.png", torch.full((3, 32, 32), 0.4), RGB)
    assert main(["synth", "flat.png", *QUICK, "--energy", "e.png"]) == 0
    np.testing.assert_array_equal(read_array("flat_synth.png")[0], np.full((48, 64, 3), 102))


def test_score_as_table_and_as_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_image("noise.png", torch.rand(3, 64, 64, generator=torch.Generator().manual_seed(0)), RGB)
    assert main(["score", "brick.png", "brick.png", "noise.png"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["output", "brick.png", "noise.png"]
    assert "coverage" in lines[0]
    assert main(["score", "brick.png", "brick.png", "noise.png", "--json"]) == 0
    same, noise = json.loads(capsys.readouterr().out)
    assert same["output"] == "brick.png"
    assert same["forward"] == 0
    assert noise["overall"] > same["overall"]


def test_videos_are_scored_from_files_and_folders(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = torch.stack(
        [torch.rand(3, 24, 24, generator=torch.Generator().manual_seed(0)).roll(t, 2) for t in range(9)], 1
    )
    write_video("clip", clip, 10)
    write_video("back.gif", clip.flip(1), 10)
    assert main(["score", "clip", "clip", "back.gif"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["output", "clip", "back.gif"]
    assert main(["score", "clip", "clip", "back.gif", "--json"]) == 0
    same, back = json.loads(capsys.readouterr().out)
    assert same["forward"] == 0
    assert back["direction"] > 1.5
    assert list(back) == lines[0].split()
