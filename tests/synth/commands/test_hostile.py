"""Hostile files and arguments, and options that a run would ignore: one sentence, exit code 2, nothing touched."""

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import tifffile
import torch
from PIL import Image
from textures import noise

from synth import Kind, write_flow, write_image
from synth.cli import main
from synth.commands import checks
from synth.io.videos import read_video, write_video

GRAY, RGB, RGBA = (Kind("uint8", tuple(names)) for names in ("Y", "RGB", "RGBA"))
LONG = "x" * 300


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder with an exemplar, a.png, its mask, m.png, and frames, clip."""
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise(3, 24, 24), RGB)
    mask = torch.zeros(1, 24, 24)
    mask[:, 8:16, 8:16] = 1
    write_image("m.png", mask, GRAY)
    write_video("clip", noise(3, 6, 12, 16), 10, RGB)
    return tmp_path


def zipped(name: str, member: str, content: bytes) -> None:
    with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(member, content)


def npy_head(*shape: int) -> bytes:
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def test_archives_of_text_and_archives_that_unpack_to_gigabytes(folder: Path, refused: Callable[..., str]) -> None:
    zipped("text.npz", "flow.npy", b"hello")
    zipped("words.npz", "notes.txt", b"hello")
    zipped("bomb.npz", "flow.npy", npy_head(2, 20000, 20000) + bytes(1000))
    Path("bomb.npy").write_bytes(npy_head(2, 20000, 20000) + bytes(1000))
    for name in ("text.npz", "words.npz"):
        assert f"{name} is no NumPy file of numbers" in refused("flow", name, "-o", "a.flo")
    for name in ("bomb.npz", "bomb.npy"):
        assert f"{name} holds arrays of 3200000000 bytes; at most 2147483648" in refused("flow", name, "-o", "a.flo")


def test_many_arrays_that_are_too_much_together(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez("many.npz", flow=np.zeros((2, 5, 5), np.float32), other=np.zeros((2, 5, 5), np.float32))
    monkeypatch.setattr("synth.io.numpy_files.MOST_BYTES", 500)  # each has 328 with its head
    assert "many.npz holds arrays of 656 bytes; at most 500" in refused("flow", "many.npz", "-o", "a.flo")


def test_a_flow_that_stands_still_when_it_is_stretched(folder: Path, refused: Callable[..., str]) -> None:
    flow = torch.zeros(2, 30, 40)
    flow[0, 15, 20] = 1e-42
    write_flow("tiny.flo", flow)
    assert "stands still; leave out its speed" in refused(
        "flow", "tiny.flo", "-o", "a.flo", "--size", "20x10", "--speed", "3"
    )


@pytest.mark.parametrize(
    ("dtype", "options", "sentence"),
    [
        ("complex64", {}, "holds complex64 pixels"),
        ("int8", {}, "holds int8 pixels"),
        ("uint32", {}, "holds uint32 pixels"),
        ("float64", {"by": 1e300}, "has values beyond 1e+18; scale them down"),
        ("float32", {"by": 3e38}, "has values beyond 1e+18; scale them down"),
        ("uint8", {"photometric": "separated", "channels": 4}, "holds CMYK colors; convert it to RGB"),
        ("uint8", {"photometric": "cielab", "channels": 3}, "holds Lab colors; convert it to RGB"),
    ],
)
def test_pixels_that_mean_something_else_are_refused_by_all(
    folder: Path, refused: Callable[..., str], dtype: str, options: dict, sentence: str
) -> None:
    values = np.random.default_rng(0).random((24, 24, options.get("channels", 1))) * options.get("by", 100)
    named = {name: value for name, value in options.items() if name == "photometric"}
    tifffile.imwrite("in.tif", values.astype(dtype).squeeze(), **named)
    for command in ("synth in.tif", "fill in.tif --hole m.png", "quilt in.tif", "score in.tif in.tif"):
        assert f"in.tif {sentence}" in refused(*command.split())
    assert sentence in refused("merge", "in.tif", "a.png", "--keep", "m.png")
    assert sentence in refused("animate", "in.tif", "--flow", "sink")


def test_a_tiff_without_height(folder: Path, refused: Callable[..., str]) -> None:
    tifffile.imwrite("flat.tif", np.zeros((777, 24), np.uint8), metadata=None)
    data = Path("flat.tif").read_bytes()
    for kind in (3, 4):
        data = data.replace(struct.pack("<HHII", 257, kind, 1, 777), struct.pack("<HHII", 257, 4, 1, 0))
    Path("flat.tif").write_bytes(data)
    for command in ("quilt flat.tif", "merge flat.tif a.png --keep m.png", "synth flat.tif"):
        assert "flat.tif says that it is 24x0 with 1 channel; get it anew" in refused(*command.split())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["synth", f"{LONG}.png"], "cannot be the name of a file; give another, of at most 255 bytes"),
        (["synth", "a.png", "-o", f"{LONG}.png"], "cannot be the name of a file"),
        (["synth", "a.png", "-o", "ä" * 128 + ".png"], "cannot be the name of a file"),
        (["synth", "a.png", "-o", "/".join([LONG[:250]] * 20)], "cannot be the name of a file"),
        (["synth", "a.png", "-o", "b\0.png"], "cannot be the name of a file"),
        (["synth", "a.png", "--also", f"n={LONG}.png"], "cannot be read (File name too long)"),
        (["synth", "a.png", "--also", "n=b\0.png"], "cannot be read (embedded null byte)"),
        (["synth", "b\udcff.png"], "b\\udcff.png does not exist"),
        (["flow", f"{LONG}.flo", "-o", "b.flo"], "cannot be read (File name too long)"),
        (["animate", "a.png", "--flow", f"{LONG}.flo"], "cannot be read (File name too long)"),
        (["flow", "b\0.flo", "-o", "b.flo"], "cannot be read (embedded null byte)"),
        (["animate", "a.png", "--flow", "b\0.npz"], "cannot be read (embedded null byte)"),
        (["synth", "a.png", "--progress-images", "a_synth.png"], "a_synth.png would be written twice"),
        (["synth", "a.png", "--threads", "100000"], "'100000' is no whole number from 1 to 256"),
        (["synth", "a.png", "--start", "a.png", "--start", "b.png"], "argument --start: it is given twice"),
        (["synth", "a.png", "--guide", "a=b", "--guide", "c=d", *["--guide-weight=1"] * 3], "2 --guides but 3 weights"),
        (["quilt", "a.png", "--seams", "a_quilt.png"], "a_quilt.png would be written twice"),
        (["merge", "a.png", "a.png", "--keep", "m.png", "--seams", "a_merge.png"], "a_merge.png would be written"),
        (["quilt", "a.png", "--scale=1e9:1"], "'1e9:1' are no scales from 0.1 to 10"),
        (["quilt", "a.png", "--seconds", "nan"], "'nan' is no number above 0"),
        (["quilt", "a.png", "--seconds=-5"], "'-5' is no number above 0"),
        (["quilt", "a.png", "--feather", "inf"], "'inf' is no number from 0 to 100"),
        (["flow", "noise:" + "9" * 5000, "-o", "b.flo"], "has no number for its seed"),
        (["flow", "noise:-3", "-o", "b.flo"], "the seed is -3; give a whole number from 0 on"),
        (["flow", "sink", "-o", "b.flo", "--size", "100000x2000"], "is too large; ask for at most 65536 a side"),
        (["animate", "a.png", "--flow", "noise:" + "9" * 400], "cannot be used (File name too long)"),
    ],
)
def test_impossible_arguments(folder: Path, refused: Callable[..., str], arguments: list[str], sentence: str) -> None:
    assert sentence in refused(*arguments)


def test_a_seed_may_be_longer_than_any_float(folder: Path) -> None:
    assert main(["flow", "noise:" + "9" * 400, "-o", "b.flo", "--size", "8x8"]) == 0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["flow", "sink", "-o", "b.npy", "--size", "9x9", "--frames", "99"],
            "in 99 frames would need 0.0 GB of memory",
        ),
        (["animate", "a.png", "--flow", "sink", "--loop", "9", "--size", "24x24"], "GB on the disk of "),
        (
            ["animate", "a.png", "--flow", "sink", "--frames", "9", "--size", "24x24", "-o", "b"],
            "are free; ask for fewer",
        ),
        (["quilt", "clip", "-o", "b", "--frames", "9"], "16x12 for 9 frames is too large"),
        (["flow", "sink", "-o", "b.flo", "--size", "40x40"], "40x40 is too large; ask for at most"),
    ],
)
def test_a_machine_too_small(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch, arguments: list[str], sentence: str
) -> None:
    monkeypatch.setattr(checks.os, "sysconf", lambda name: 100)
    monkeypatch.setattr(checks.shutil, "disk_usage", lambda folder: SimpleNamespace(free=1000))
    monkeypatch.setattr(checks, "_MOST_PIXELS", 1500)
    assert sentence in refused(*arguments)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        *[(f"quilt a.png {option}", f"--{option.split()[0][2:]} is for videos but a.png is an image; leave it out")
          for option in ("--mode time", "--frames 9", "--loop", "--hold 3", "--fps 9")],
        *[(f"quilt clip -o b {option}", f"{option.split('=')[0].split()[0]} is for --mode time and spacetime but a")
          for option in ("--placement sub", "--k 0.5", "--refine 5", "--seconds 1", "--tile", "--rotate=9", "--mirror",
                         "--scale 0.5:1", "--hold 3")],
        ("quilt clip -o b --mode time --hold 3", "--hold is for a --loop in --mode time or spacetime"),
        ("quilt clip -o b --fps 9", "--fps is for video files but b is to be a folder of frames; leave it out"),
        ("quilt a.png --placement random --k 0.5", "--k is for --placement whole and sub but it is random"),
        ("quilt a.png --perspective", "--perspective needs a range of scales and no tile; give --scale A:B without"),
        ("animate a.png --flow sink -o b --fps 9", "--fps is for video files but b is to be a folder of frames"),
        ("animate a.png --flow sink --resample", "--resample stretches a file's flow but sink is made for any size"),
        ("flow sink -o b.flo --arrows 3", "--arrows is for a --picture but there is none; leave it out"),
        ("synth clip -o b --verbose", "--verbose is for images but clip is a video; leave it out"),
        ("synth a.png --guide-weight 2", "--guide-weight says what a --guide counts but there is none; leave it out"),
    ],
)  # fmt: skip
def test_options_that_would_be_ignored(
    folder: Path, refused: Callable[..., str], arguments: str, sentence: str
) -> None:
    assert sentence in refused(*arguments.split())


def test_what_cannot_be_measured_in_a_minute_is_refused(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    tifffile.imwrite("many.tif", np.zeros((24, 24, 17), np.float32), photometric="minisblack", planarconfig="contig")
    assert "many.tif is 24x24 with 17 channels; at most" in refused("score", "many.tif", "many.tif")
    Image.new("1", (4097, 4096)).save("large.png")
    assert "large.png is 4097x4096 with 1 channel; at most 2^24 pixels" in refused("score", "large.png", "large.png")
    write_video("short", noise(3, 4, 12, 16), 10)
    monkeypatch.setattr("synth.commands.score._MOST_FRAMES_PIXELS", 700)
    assert "short is 16x12 with 3 channels and 4 frames long; at most" in refused("score", "short", "short")


def test_merge_heeds_the_number_of_threads(folder: Path) -> None:
    before = torch.get_num_threads()
    try:
        assert main(["merge", "a.png", "a.png", "--keep", "m.png", "--at", "3,3", "--threads", str(before + 1)]) == 0
        assert torch.get_num_threads() == before + 1
    finally:
        torch.set_num_threads(before)


def test_a_video_that_would_never_end_is_refused(
    folder: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [Image.fromarray((noise(12, 16, 3).roll(t, 1) * 255).byte().numpy()) for t in range(8)]
    frames[0].save("odd.gif", save_all=True, append_images=frames[1:], duration=[30, 655350, *[10] * 6], loop=0)
    assert main(["quilt", "odd.gif", "--loop", "-o", "out.gif"]) == 0
    assert read_video("out.gif").frames.shape[2:] == (12, 16)
    monkeypatch.setattr("synth.io.videos.MOST_PIXELS", 12 * 16 * 5)
    assert "odd.gif has more than" in refused("quilt", "odd.gif", "--loop", "-o", "other.gif")
