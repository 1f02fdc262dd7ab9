"""The command line: bad input costs one sentence and leaves no file."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
import torch
from brick import QUICK, RGB, texture

from synth import Kind, write_image
from synth.cli import main
from synth.io.videos import write_video


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with one exemplar in it, brick.png."""
    monkeypatch.chdir(tmp_path)
    write_image("brick.png", texture(), RGB)
    return tmp_path


def test_stills_and_videos_are_not_mixed(folder: Path, refused: Callable[..., str]) -> None:
    write_video("clip", torch.rand(3, 2, 16, 16), 10)
    assert "brick.png is an image but clip is a video; measure images" in refused("score", "clip", "brick.png")
    assert "clip is a video but brick.png is an image" in refused("score", "brick.png", "brick.png", "clip")


def test_missing_exemplar(refused: Callable[..., str]) -> None:
    assert "none.png does not exist; check the name" in refused("synth", "none.png")
    assert "none.png does not exist; check the name" in refused("score", "brick.png", "none.png")


def test_folder_of_pictures_that_are_no_video(folder: Path, refused: Callable[..., str]) -> None:
    write_image("larger.png", texture(size=(40, 40)), RGB)
    assert "all frames must have one size" in refused("synth", ".")


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
    assert "the exemplar is 3x3 pixels" in refused("synth", "tiny.png", *QUICK)


@pytest.mark.parametrize(
    ("size", "sentence"),
    [
        ("1x1", "the output is 1x1 pixels"),
        ("-5x10", "'-5x10' is no size; write WIDTHxHEIGHT in pixels, for example 512x384"),
        ("0x64", "'0x64' is no size"),
        ("99999x64", "a size of 99999x64 is too large; ask for at most 65536 a side"),
        ("65536x65536", "is too large; ask for at most 65536 a side and 2^28 pixels in all"),
        ("64by", "'64by' is no size; write WIDTHxHEIGHT in pixels, for example 512x384"),
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
        ("-o none/", "none is no folder that exists; make it first"),
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
        ("synth brick.png --bogus", "unrecognized arguments: --bogus (see kwatra synth --help)"),
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
