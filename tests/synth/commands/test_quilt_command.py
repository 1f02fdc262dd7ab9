"""`kwatra quilt` and `kwatra merge`: what they write, and that bad input costs one sentence and leaves no file."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from textures import noise

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.io.videos import read_video, write_video

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise(3, 24, 32), RGB)
    write_image("b.png", noise(3, 16, 16, seed=1), RGB)
    write_image("tiny.png", noise(3, 5, 5), RGB)
    mask = torch.zeros(1, 16, 16)
    mask[:, 6:10, 6:10] = 1
    write_image("keep.png", mask, GRAY)
    write_image("none.png", mask * 0, GRAY)
    write_video("clip", noise(3, 6, 12, 16), 10, RGB)
    return tmp_path


def test_quilt_writes_the_picture_its_seams_and_its_map(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "quilt",
        "a.png",
        "-o",
        "out.png",
        "--size",
        "40x30",
        "--refine",
        "3",
        "--seams",
        "s.png",
        "--map",
        "m.npy",
    ]
    assert main(command) == 0
    assert "wrote out.png, s.png and m.npy: 40x30" in capsys.readouterr().out
    image, source = read_image("out.png").pixels, read_image("a.png").pixels
    table = np.load("m.npy")
    assert table.shape == (3, 30, 40)
    np.testing.assert_array_equal(image.numpy(), source.numpy()[:, table[1], table[2]])
    assert read_image("s.png").pixels.shape == (3, 30, 40)


def test_the_same_seed_writes_the_same_bytes(folder: Path) -> None:
    for name, threads in (("x.png", "1"), ("y.png", "2")):
        assert main(["quilt", "a.png", "-o", name, "--refine", "4", "--placement", "sub", "--threads", threads]) == 0
    assert Path("x.png").read_bytes() == Path("y.png").read_bytes()


@pytest.mark.parametrize(
    ("options", "frames", "size"),
    [
        ([], None, (12, 16)),
        (["--loop"], None, (12, 16)),
        (["--frames", "9"], 9, (12, 16)),
        (["--mode", "time"], 12, (12, 16)),
        (["--mode", "time", "--frames", "10", "--loop", "--hold", "2"], 10, (12, 16)),
        (["--mode", "spacetime", "--frames", "8", "--refine", "2"], 8, (12, 16)),
        (["--size", "20x15", "--frames", "8", "--loop", "--hold", "3", "--refine", "2"], 8, (15, 20)),
    ],
)
def test_quilt_makes_videos(folder: Path, options: list[str], frames: int | None, size: tuple[int, int]) -> None:
    assert main(["quilt", "clip", "-o", "out/", *options]) == 0  # a folder, which is made
    made = read_video("out").frames
    assert made.shape[2:] == size
    assert made.shape[1] == frames or frames is None


@pytest.mark.parametrize("name", ["out.mp4", "out.gif"])
def test_quilt_writes_video_files(folder: Path, name: str) -> None:
    assert main(["quilt", "clip", "-o", name, "--mode", "time", "--fps", "10"]) == 0
    made = read_video(name)
    assert made.frames.shape == (3, 12, 12, 16)
    assert made.rate == pytest.approx(10)


def test_all_outputs_of_a_video_appear_or_none(folder: Path, refused: Callable[..., str], monkeypatch) -> None:
    def full(*rest: object) -> None:
        raise OSError(errno.ENOSPC, "full")

    command = ["quilt", "clip", "-o", "out", "--mode", "time", "--seams", "seams", "--map", "m.npy"]
    with monkeypatch.context() as broken:
        broken.setattr(os, "fsync", full)
        assert "the disk is full" in refused(*command)
    assert main(command) == 0
    assert read_video("out").frames.shape == read_video("seams").frames.shape
    assert np.load("m.npy").shape == (4, 12, 12, 16)


@pytest.mark.parametrize(
    "options", [["--rotate"], ["--rotate=30,-15", "--mirror"], ["--scale", "0.8:1"], ["--scale", "0.9"]]
)
def test_copies_of_the_exemplar_are_used_too(folder: Path, options: list[str]) -> None:
    assert main(["quilt", "a.png", "-o", "out.png", "--map", "m.npy", "--refine", "2", *options]) == 0
    plain = ["quilt", "a.png", "-o", "plain.png", "--refine", "2"]
    assert main(plain) == 0
    assert Path("plain.png").read_bytes() != Path("out.png").read_bytes()
    assert np.load("m.npy").shape == (4 if options[0].startswith("--rotate") else 3, 48, 64)


def test_an_output_is_replaced_only_when_told_to(folder: Path, refused: Callable[..., str]) -> None:
    write_video("out", noise(3, 4, 12, 16), 10, RGB)
    assert "exists" in refused("quilt", "clip", "-o", "out")
    assert main(["quilt", "clip", "-o", "out", "--mode", "time", "--overwrite"]) == 0
    assert read_video("out").frames.shape[1] == 12


def test_merge_keeps_what_it_must(folder: Path) -> None:
    assert (
        main(["merge", "a.png", "b.png", "--at", "9,3", "--keep", "keep.png", "-o", "m.png", "--seams", "s.png"]) == 0
    )
    merged = read_image("m.png").pixels
    torch.testing.assert_close(merged[:, 9:13, 15:19], read_image("b.png").pixels[:, 6:10, 6:10])
    torch.testing.assert_close(merged[:, :, :9], read_image("a.png").pixels[:, :, :9])


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("quilt tiny.png", "5x5 pixels, smaller than the overlap"),
        ("quilt nothing.png", "does not exist"),
        ("quilt nothing.mp4", "does not exist"),
        ("quilt a.png --loop", "is for videos"),
        ("quilt a.png --size 0x9", "is no size"),
        ("quilt a.png --size 100000x100000", "ask for at most 65536 a side"),
        ("quilt a.png --k 7", "'7' is no number from 0.001 to 1"),
        ("quilt a.png --scale 0:1", "'0:1' are no scales from 0.1 to 10"),
        ("quilt --rotate a.png", "'a.png' are no numbers"),
        ("quilt a.png --perspective", "--perspective needs a range of scales"),
        ("quilt a.png --feather 2 --spline", "not allowed with"),
        ("quilt a.png -o b.png", "exists"),
        ("quilt a.png -o no/b.png", "does not exist"),
        ("quilt clip -o x.avi", "ending that no video can have"),
        ("quilt clip -o x --mode time --loop --hold 7", "hold is 7 but the clip has 6 frames"),
        ("quilt clip -o x --mode time --size 20x20", "use mode spacetime"),
        ("quilt clip -o x --frames 1", "'1' is no whole number from 2 to 1000000000000"),
        ("quilt clip -o x --loop --frames 11", "no loop of this clip"),
        ("quilt one -o x", "the video has one frame but needs at least two; give a longer one, or quilt the frame"),
        ("quilt differing -o x", "all frames must have one size"),
        ("quilt broken.mp4", "is no video that can be read"),
        ("merge a.png b.png --keep none.png", "is empty"),
        ("merge a.png b.png --at 90,0 --keep keep.png", "does not overlap the background"),
        ("merge a.png b.png --at 26,0 --keep keep.png", "no kept pixel of overlay 1 lies on the background"),
        ("merge a.png b.png b.png --keep keep.png --keep keep.png", "are kept by an earlier one"),
        ("merge a.png b.png --keep keep.png --spare keep.png", "both to be kept and to be spared"),
        ("merge a.png b.png --keep a.png", "draw it at the overlay's size"),
        ("merge a.png b.png b.png --keep keep.png", "there are 2 overlays but 1 of --keep; give one for each"),
    ],
)
def test_bad_input_costs_one_sentence(folder: Path, refused: Callable[..., str], arguments: str, reason: str) -> None:
    Path("one").mkdir()
    write_image("one/0.png", noise(3, 9, 9), RGB)
    Path("differing").mkdir()
    write_image("differing/0.png", noise(3, 9, 9), RGB)
    write_image("differing/1.png", noise(3, 9, 8), RGB)
    Path("broken.mp4").write_bytes(b"no video")
    assert reason in refused(*arguments.split())
