"""`kwatra animate`: what it refuses."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from conftest import contents
from sand import GRAY, RGB, SAND, SHAPE, but, texture, written

import flow
from synth import write_flow, write_image
from synth.cli import main


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with an exemplar and a flow."""
    monkeypatch.chdir(tmp_path)
    written()
    return tmp_path


def test_a_folder_from_other_settings(folder: Path, refused: Callable[..., str]) -> None:
    write_image("start.png", texture(size=96)[:, :40, :48], GRAY)
    assert main([*SAND, "--frames", "2", "-o", "out"]) == 0
    for changed, sentence in (
        ("--flow sink", "another --flow;"),
        ("--speed 1 --seed 1", "another --speed and another --seed; give the same again, or begin anew"),
        ("--size 48x42", "another --size;"),
        ("--preset default", "another --preset;"),
        ("--turn off", "another --turn;"),
        ("--obstacle disc", "another --obstacle;"),
        ("--fill-from left", "another --fill-from;"),
        ("--first start.png", "another --first;"),
        ("--frames 1", "out has 2 frames already, more than the 1 asked for; give --frames 2 or more"),
    ):
        assert sentence in refused(*but([*SAND, "--frames", "2", "-o", "out"], changed), "--resume")


@pytest.mark.parametrize("speed", ["fast", "nan", "inf", "2px"])
def test_a_speed_that_is_no_number(folder: Path, refused: Callable[..., str], speed: str) -> None:
    assert f"--speed: {speed!r} is no finite number; write one, for example 2.5" in refused(*SAND, "--speed", speed)


def test_a_folder_from_other_files_or_another_length_of_loop(folder: Path, refused: Callable[..., str]) -> None:
    command = ["animate", "sand.png", "--flow", "wind.flo", "--preset", "fast", "-o", "out"]
    assert main([*command, "--loop", "2"]) == 0
    assert "another --loop;" in refused(*command, "--loop", "3", "--resume")
    assert "another --loop;" in refused(*command, "--frames", "3", "--resume")
    write_flow("wind.flo", flow.sink(1.1)(0.0, (30, 36)), overwrite=True)
    write_image("sand.png", 1 - texture(), GRAY, overwrite=True)
    assert "another exemplar and another --flow;" in refused(*command, "--loop", "2", "--resume")


def test_nothing_to_go_on_with(folder: Path, refused: Callable[..., str]) -> None:
    assert main([*SAND, "--frames", "2", "-o", "out.mp4"]) == 0
    assert "out.mp4 is whole, there is nothing to resume" in refused(*SAND, "-o", "out.mp4", "--resume")
    assert main([*SAND, "--frames", "2", "-o", "out"]) == 0
    Path("out/000000.png").unlink()
    assert "out lacks 000000.png; begin anew with --overwrite" in refused(*SAND, "-o", "out", "--resume")
    Path("out/.state.npz").write_bytes(b"no archive")
    assert "out/.state.npz is damaged; begin anew" in refused(*SAND, "-o", "out", "--resume")


def test_what_exists_is_not_replaced_unasked(folder: Path, refused: Callable[..., str]) -> None:
    assert main([*SAND, "--frames", "2", "-o", "out"]) == 0
    assert "out holds frames (2 of them); go on with --resume, or begin anew with --overwrite" in refused(
        *SAND, "-o", "out"
    )
    Path("out/notes.txt").write_text("mine")
    sentence = "out holds other things than an animation's frames; name another folder"
    assert sentence in refused(*SAND, "-o", "out", "--overwrite")
    Path("photos").mkdir()
    write_image("photos/000000.png", texture(), GRAY)  # named like a frame, but no run wrote it
    assert "photos holds other things" in refused(*SAND, "-o", "photos", "--overwrite")


def test_full_disk_keeps_the_frames_that_are_whole(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SAND, "--frames", "2", "-o", "out"]) == 0
    before = contents(folder)

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    capsys.readouterr()
    monkeypatch.setattr(os, "fsync", full)
    assert main([*SAND, "--frames", "3", "-o", "out", "--resume"]) == 2
    assert "000002.png was not written because the disk is full" in capsys.readouterr().err
    assert contents(folder) == before


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("--flow snik", "'snik' names no flow; give one of uniform, rotation"),
        ("--flow nan.npy", "nan.npy has 1 vector of NaN"),
        ("--flow far.npy", "beyond the 48x40 frame; give a lower speed"),
        (
            "--flow gust.npy --frames 5",
            "gust.npy holds 3 flows, which lead to 4 frames, but 5 are asked for; give --fr",
        ),
        ("--flow gust.npy --loop 4", "which lead to 3 frames, but 4 are asked for; give --loop 3 or less, or a longer"),
        ("--flow rotation --speed 99", "beyond the 48x40 frame; give a lower speed"),
        ("--flow rotation --speed nan", "'nan' is no finite number"),
        ("--flow cut.flo", "cut.flo has 4000 bytes"),
        ("--flow magic.flo", "magic.flo is no Middlebury flow"),
        ("--flow wind.flo", "wind.flo is 36x30 but the frames are to be 48x40; leave out --size, or stretch it with"),
        ("--obstacle all.png", "all.png covers the whole frame"),
        ("--obstacle none.png", "none.png leaves the whole frame free"),
        ("--obstacle sand.png", "sand.png is 64x64 but the frames are to be 48x40"),
        ("--obstacle disc:1,1,99", "the disc covers the whole frame"),
        ("--obstacle disc:900,1,9", "the disc leaves the whole frame free"),
        ("--obstacle disc:1,1", "'disc:1,1' is no disc; write disc, or disc:X,Y,RADIUS"),
        ("--frames 0", "'0' is no whole number from 1 to 1000000000000"),
        ("--loop 1", "'1' is no whole number from 2 to 1000000000000"),
        (f"--loop 1{400 * '0'}", "0' is no whole number from 2 to 1000000000000"),
        ("--loop 5 --frames 5", "argument --frames: not allowed with argument --loop"),
        ("--loop 5 --fill-from left", "--loop leads back to the first frame, but with --fill-from that is empty"),
        ("--first all.png --fill-from left", "argument --fill-from: not allowed with argument --first"),
        ("--first sand.png", "sand.png is 64x64 but the frames are to be 48x40"),
        ("--first color.png", "color.png holds uint8 RGB but sand.png holds uint8 Y; save it like the exemplar"),
        ("--size 3x40", "frames of 3x40 are too small; give at least 4 pixels a side"),
        ("--size 99999x40", "is too large; ask for at most 65536 a side"),
        ("--fps 0", "'0' is no number of frames a second from 0.1 to 1000"),
        ("-o out.avi", "out.avi has an ending that no video can have; use .mp4, .gif, .webm or .mov"),
        ("-o nowhere/out.mp4", "because the folder nowhere does not exist"),
        ("-o nowhere/out", "because the folder nowhere does not exist"),
        ("-o words", "words is a file; name a folder"),
        ("-o old.mp4", "old.mp4 exists; name another file or allow it with --overwrite"),
    ],
)
def test_bad_input_costs_a_sentence(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch, arguments: str, sentence: str
) -> None:
    vectors = np.zeros((2, *SHAPE), np.float32)
    np.save("far.npy", vectors + 60)
    np.save("gust.npy", np.stack([vectors] * 3))
    vectors[0, 3, 3] = np.nan
    np.save("nan.npy", vectors)
    data = Path("wind.flo").read_bytes()
    Path("cut.flo").write_bytes(data[:4000])
    Path("magic.flo").write_bytes(b"PIEX" + data[4:])
    write_image("all.png", torch.ones(1, *SHAPE), GRAY)
    write_image("none.png", torch.zeros(1, *SHAPE), GRAY)
    write_image("color.png", texture(3, 48)[:, :40], RGB)
    Path("words").touch()
    Path("old.mp4").touch()
    monkeypatch.setattr("kwatra.optimize", lambda *_, **__: pytest.fail("the work began"))
    assert sentence in refused(*but(SAND, arguments))
