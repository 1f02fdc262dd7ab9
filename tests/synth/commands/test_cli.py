"""The command line: what it writes, and that bad input costs one sentence and leaves no file."""

import csv
import errno
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from PIL import Image

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.io.images import read_array, read_values
from synth.io.videos import write_video

RGB = Kind("uint8", ("R", "G", "B"))
QUICK = ["--preset", "fast", "--size", "64x48"]


def texture(channels: int = 3, size: tuple[int, int] = (64, 64), seed: int = 0) -> torch.Tensor:
    """Stripes with noise: (C, H, W) in [0, 1]."""
    generator = torch.Generator().manual_seed(seed)
    wave = torch.sin(torch.arange(size[1]) * 0.8) * 0.3 + 0.5
    return (wave + 0.1 * torch.randn(channels, *size, generator=generator)).clamp(0, 1)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with one exemplar in it, brick.png."""
    monkeypatch.chdir(tmp_path)
    write_image("brick.png", texture(), RGB)
    return tmp_path


# ---- what it does


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
    assert main([*command, "--progress-images", "levels", "--overwrite", "--energy", "e.png"]) == 0
    with Path("e.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["level"] for row in rows] == sorted(row["level"] for row in rows)
    assert all(float(row["total"]) >= 0 for row in rows)
    with Image.open("e.png") as image:
        assert image.size == (960, 480)
    stages = sorted(path.name for path in Path("levels").iterdir())
    assert stages == ["level_1_scale2_width16.png", "level_2_scale1_width8.png"]
    assert read_image("levels/level_2_scale1_width8.png").pixels.shape == (3, 48, 64)
    source = np.load("m.npy")
    assert source.dtype == np.int32
    assert source.shape == (4, 48, 64)  # the fourth row: how mirrored copies lie
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


# ---- what it refuses


def test_stills_and_videos_are_not_mixed(folder: Path, refused: Callable[..., str]) -> None:
    write_video("clip", torch.rand(3, 2, 16, 16), 10)
    assert "brick.png is an image but clip is a video; measure images" in refused("score", "clip", "brick.png")
    assert "clip is a video but brick.png is an image" in refused("score", "brick.png", "brick.png", "clip")


def test_missing_exemplar(refused: Callable[..., str]) -> None:
    assert "none.png does not exist; check the name" in refused("synth", "none.png")
    assert "none.png does not exist; check the name" in refused("score", "brick.png", "none.png")


def test_folder_as_exemplar(refused: Callable[..., str]) -> None:
    assert "a video needs at least 2" in refused("synth", ".")


def test_empty_exemplar(folder: Path, refused: Callable[..., str]) -> None:
    Path("empty.png").touch()
    assert "empty.png is empty; give" in refused("synth", "empty.png")


def test_truncated_exemplar(folder: Path, refused: Callable[..., str]) -> None:
    Path("cut.png").write_bytes(Path("brick.png").read_bytes()[:500])
    assert "cut.png is damaged or cut short" in refused("synth", "cut.png")


def test_exemplar_that_is_no_image(folder: Path, refused: Callable[..., str]) -> None:
    Path("words.png").write_text("not an image")
    assert "words.png is not a PNG, JPEG, TIFF, EXR, WebP, BMP or TGA image; convert it" in refused(
        "synth", "words.png"
    )


def test_exemplar_smaller_than_a_window(folder: Path, refused: Callable[..., str]) -> None:
    write_image("tiny.png", torch.zeros(3, 3, 3), RGB)
    assert "only 3 px" in refused("synth", "tiny.png", *QUICK)


@pytest.mark.parametrize(
    ("size", "sentence"),
    [
        ("1x1", "only 1 px"),
        ("0x64", "'0x64' is no size"),
        ("99999x64", "a size of 99999x64 is too large; ask for at most 65536 a side"),
        ("65536x65536", "is too large; ask for at most 65536 a side and 2^28 pixels in all"),
        ("64by", "'64by' is no size; write WIDTHxHEIGHT in pixels, for example 512x384"),
        ("-3x5", "--size"),
    ],
)
def test_impossible_size(refused: Callable[..., str], size: str, sentence: str) -> None:
    assert sentence in refused("synth", "brick.png", "--size", size)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_pixels_that_are_not_finite(folder: Path, refused: Callable[..., str], bad: float) -> None:
    pixels = texture().permute(1, 2, 0).numpy()
    pixels[5, 6, 0] = bad
    tifffile.imwrite("bad.tif", pixels, photometric="rgb")
    assert "bad.tif has 1 value not finite, NaN or infinite; replace them" in refused("synth", "bad.tif")


def test_exemplars_of_different_channels(folder: Path, refused: Callable[..., str]) -> None:
    write_image("gray.png", texture(1), Kind("uint8", ("Y",)))
    tifffile.imwrite("five.tif", np.zeros((32, 32, 5), np.uint8), photometric="minisblack", planarconfig="contig")
    assert "five.tif holds uint8" in refused("synth", "brick.png", "five.tif", *QUICK)
    assert "an output has its exemplar's channels" in refused("score", "brick.png", "gray.png")
    assert "gray.png holds uint8 Y but the exemplar" in refused("synth", "brick.png", "--start", "gray.png")


def test_map_of_another_size(folder: Path, refused: Callable[..., str]) -> None:
    write_image("small.png", texture(1, (32, 48)), Kind("uint8", ("Y",)))
    sentence = refused("synth", "brick.png", "--also", "height=small.png", *QUICK)
    assert "small.png is 48x32 but its exemplar is 64x64; a map has its exemplar's size" in sentence


@pytest.mark.parametrize(
    ("also", "sentence"),
    [
        ("brick.png", "write NAME=FILE, for example normal=brick_n.png"),
        ("n=", "write NAME=FILE"),
        ("a/b=brick.png", "write NAME=FILE"),
        ("n=none.png", "none.png does not exist"),
        ("n=brick.png", "names 1 file for 2 exemplars; give one each, with commas"),
        ("n=brick.png,gray.png", "gray.png holds uint8 Y but brick.png holds uint8 RGB; save both maps alike"),
    ],
)
def test_map_that_cannot_be_used(folder: Path, refused: Callable[..., str], also: str, sentence: str) -> None:
    write_image("gray.png", texture(1), Kind("uint8", ("Y",)))
    count = 2 if "," in also or "1 file " in sentence else 1
    assert sentence in refused("synth", *["brick.png"] * count, *QUICK, "--also", also)


def test_start_of_another_size(folder: Path, refused: Callable[..., str]) -> None:
    sentence = refused("synth", "brick.png", "--start", "brick.png", "--size", "60x50")
    assert "brick.png is 64x64 but --size asks for 60x50; leave --size out" in sentence


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("-o old.png", "old.png exists; name another file or allow it with --overwrite"),
        ("--map old.png", "old.png exists"),
        ("--energy old.png", "old.png exists"),
        ("--also old=brick.png -o brick.png --overwrite --map brick_old.png", "brick_old.png would be written twice"),
        ("-o nowhere/out.png", "because the folder nowhere does not exist; make it first"),
        ("--energy nowhere/e.csv", "because the folder nowhere does not exist"),
        ("--progress-images nowhere/there", "because nowhere does not exist; make that first"),
        ("--progress-images old.png", "old.png is a file; name a folder"),
        ("--progress-images full", "full already holds progress images; name another folder"),
        ("-o out.gif", "out.gif has an ending that cannot hold uint8 RGB pixels; end it with .png or"),
        ("-o out.exr", "out.exr has an ending that cannot hold uint8 RGB pixels"),
        ("-o full/", "full/brick_synth.png exists"),
        ("-o none/", "'none/' is no folder that exists; make it first"),
        ("--map m.jpg", "m.jpg has an ending that cannot hold it; end it with .npy or .png"),
        ("--energy e.txt", "e.txt has an ending that cannot hold it; end it with .csv or .png"),
    ],
)
def test_output_that_could_not_be_written(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch, arguments: str, sentence: str
) -> None:
    write_image("old.png", torch.zeros(3, 8, 8), RGB)
    Path("full").mkdir()
    Path("full/level_1.png").touch()
    Path("full/brick_synth.png").touch()
    monkeypatch.setattr("synth.texture.images.synthesize", lambda *_, **__: pytest.fail("the work began"))
    assert sentence in refused("synth", "brick.png", *QUICK, *arguments.split())


def test_full_disk(folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0

    def full_at_the_second(_: int) -> None:
        nonlocal calls
        calls += 1
        if calls == 2:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_at_the_second)
    sentence = refused("synth", "brick.png", *QUICK, "--map", "m.npy", "--energy", "e.csv")
    assert "m.npy was not written because the disk is full; free some space" in sentence


def test_not_enough_memory(refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch) -> None:
    def no_memory(*_: object, **__: object) -> None:
        raise RuntimeError("DefaultCPUAllocator: can't allocate memory: you tried to allocate 1 bytes.")

    monkeypatch.setattr("synth.texture.images.synthesize", no_memory)
    assert "there is not enough memory; ask for a smaller --size" in refused("synth", "brick.png")


def test_a_fault_of_our_own_is_not_hidden(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ValueError("a fault")

    monkeypatch.setattr("synth.texture.images.synthesize", broken)
    with pytest.raises(ValueError, match="a fault"):
        main(["synth", "brick.png"])


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device here")
def test_cuda_where_there_is_none(refused: Callable[..., str]) -> None:
    assert "there is no CUDA device here; use cpu" in refused("synth", "brick.png", "--device", "cuda")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("synth brick.png --bogus", "unrecognized arguments: --bogus (see kwatra --help)"),
        ("synth", "required: EXEMPLAR"),
        ("score brick.png", "required: OUTPUT"),
        ("", "required: COMMAND"),
        ("weave brick.png", "invalid choice: 'weave'"),
        ("synth brick.png --levels 4-32", "'4-32' are no levels; write SCALE:WIDTH,..."),
        ("synth brick.png --levels 3:8", "factor is 3"),
        ("synth brick.png --rotate ten", "'ten' are no numbers; write them with commas"),
        ("synth brick.png --scale 1000", "'1000' are no scales from 0.1 to 10; write F,F,... as 0.8,1.25, or A:B"),
        ("synth brick.png --seed -1", "--seed"),
        ("synth brick.png --threads 0", "'0' is no whole number from 1 to 256"),
        ("synth brick.png --preset slow", "invalid choice: 'slow'"),
    ],
)
def test_unusable_arguments(refused: Callable[..., str], arguments: str, sentence: str) -> None:
    assert sentence in refused(*arguments.split())


# ---- as a process


def python(*arguments: str, **options: object) -> "subprocess.Popen[str]":
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3]), "PYTHONUNBUFFERED": ""}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    return subprocess.Popen([sys.executable, *arguments], **pipes | options)


def test_interrupt_in_the_middle(folder: Path) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    program = """
import signal, sys
from synth import cli
from synth.commands import synth as commands
signal.signal(signal.SIGINT, signal.default_int_handler)
from contextlib import contextmanager
@contextmanager
def announce(title):
    yield lambda progress: print("working", flush=True)
commands.progress_line = announce
sys.exit(cli.main(["synth", "brick.png", "--preset", "best", "--progress-images", "levels"]))
"""
    with python("-c", program) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == "working\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
        assert process.stderr.read() == "kwatra: interrupted, nothing was written\n"
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_help_is_quick_because_nothing_heavy_is_imported() -> None:
    program = "import sys; from synth.cli import main\ntry: main(['synth', '--help'])\nexcept SystemExit: pass\n"
    heavy = "print([m for m in ('torch', 'numpy', 'rich', 'PIL', 'faiss') if m in sys.modules])"
    began = time.perf_counter()
    with python("-c", program + heavy) as process:
        out, _ = process.communicate()
    assert out.endswith("[]\n")
    assert "WIDTHxHEIGHT" in out
    assert time.perf_counter() - began < 2  # alone it takes a tenth of a second


@pytest.mark.parametrize("name", ["synth", "kwatra"])
def test_a_module_that_is_run_can_speak_before_anything_heavy_is_imported(name: str) -> None:
    with python(
        "-c", f"import sys, {name}\nprint([m for m in ('torch', 'numpy', 'scipy') if m in sys.modules])"
    ) as process:
        out, _ = process.communicate()
    assert out == "[]\n"


@pytest.mark.parametrize("name", ["synth", "kwatra"])
def test_runs_as_a_module(name: str) -> None:
    with python("-m", name, "--help") as process:
        out, err = process.communicate()
    assert process.returncode == 0
    assert out.startswith("usage: kwatra ")
    assert err == ""


def test_closed_pipe_is_no_traceback(folder: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with python("-m", "synth", "score", "brick.png", "brick.png", stdout=writing) as process:
        os.close(writing)
        _, err = process.communicate()
    assert process.returncode == 1
    assert err == ""
