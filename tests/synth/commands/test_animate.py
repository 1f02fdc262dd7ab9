"""`kwatra animate`: what it writes, that a run can be gone on with, and what it refuses."""

import errno
import itertools
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from conftest import contents

import flow
from kwatra import Exemplar
from synth import Kind, read_image, write_flow, write_image
from synth.cli import main
from synth.io.images import read_array
from synth.io.videos import read_video, write_video
from synth.texture.work import PRESETS

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))
SHAPE = (40, 48)
QUICK = ["--size", "48x40", "--preset", "fast"]
SAND = ["animate", "sand.png", "--flow", "rotation", *QUICK]


def texture(channels: int = 1, size: int = 64) -> torch.Tensor:
    """Noise with grains of some pixels, (channels, size, size) in [0.2, 1]."""
    generator = torch.Generator().manual_seed(0)
    noise = torch.rand(1, channels, size // 2, size // 2, generator=generator)
    return torch.nn.functional.interpolate(noise, (size, size), mode="bicubic")[0].clamp(0, 1) * 0.8 + 0.2


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a gray exemplar, sand.png, and a flow, wind.flo, of another size than QUICK's."""
    monkeypatch.chdir(tmp_path)
    write_image("sand.png", texture(), GRAY)
    write_flow("wind.flo", flow.sink(1.0)(0.0, (30, 36)))
    return tmp_path


def but(command: list[str], changed: str) -> list[str]:
    """A command with other options, in place of those that it has."""
    given = command[:2]
    for name, value in zip(command[2::2], command[3::2], strict=True):
        given += [] if name in changed.split() else [name, value]
    return [*given, *changed.split()]


def frames_of(folder: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted(Path(folder).glob("[0-9]*"))]


def interrupted(patch: pytest.MonkeyPatch, name: str, after: int) -> None:
    """Let Ctrl-C come when so many frames have been taken from flow.animate or flow.loop."""
    whole = getattr(flow, name)

    def make(*arguments: object, **named: object) -> object:
        yield from itertools.islice(whole(*arguments, **named), after)
        raise KeyboardInterrupt

    patch.setattr(flow, name, make)


# ---- what it does


def test_the_frames_are_those_of_the_engine(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SAND, "--frames", "3", "--seed", "5", "--speed", "1", "-o", "out"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("wrote out: 3 frames of 48x40 in ")
    assert out.endswith(" s per frame)\n")
    assert err == ""
    pixels = read_image("sand.png").pixels
    low, high = float(pixels.min()), float(pixels.max())
    expected = flow.animate(
        Exemplar.of((pixels - low) / (high - low)),
        flow.rotation(1.0),
        SHAPE,
        frames=3,
        renewing=flow.PRESETS["fast"],
        synthesis=PRESETS["fast"][0],
        seed=5,
    )
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        assert made.kind == GRAY
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert sorted(os.listdir("out")) == [".state.npz", "000000.png", "000001.png", "000002.png"]


@pytest.mark.parametrize(("name", "rate"), [("out.mp4", 20.0), ("out.gif", 20.0)])
def test_a_video_shows_the_frames_and_nothing_else_is_left(folder: Path, name: str, rate: float) -> None:
    assert main([*SAND, "--frames", "3", "-o", "out"]) == 0
    before = set(folder.iterdir())
    assert main([*SAND, "--frames", "3", "-o", name, "--fps", "20"]) == 0
    assert set(folder.iterdir()) - before == {folder / name}
    clip = read_video(name)
    assert clip.rate == pytest.approx(rate)
    assert clip.frames.shape == (3, 3, *SHAPE)
    torch.testing.assert_close(clip.frames, read_video("out").frames.expand(3, -1, -1, -1), rtol=0, atol=0.1)


def test_output_goes_to_the_current_folder_named_after_exemplar_and_flow(folder: Path) -> None:
    Path("deep").mkdir()
    write_image("deep/mud.png", texture(), GRAY)
    assert main(["animate", "deep/mud.png", "--flow", "uniform:90", "--frames", "2", *QUICK]) == 0
    assert main(["animate", "deep/mud.png", "--flow", "wind.flo", "--frames", "2", "--preset", "fast"]) == 0
    assert read_video("mud_uniform90.mp4").frames.shape == (3, 2, *SHAPE)
    assert read_video("mud_wind.mp4").frames.shape == (3, 2, 30, 36)  # the flow's own size


@pytest.mark.parametrize(
    "kind", [Kind("uint16", ("R", "G", "B", "A")), Kind("float32", ("R", "G", "B")), Kind("bool", ("Y",))]
)
def test_frames_are_of_the_exemplars_kind(folder: Path, kind: Kind) -> None:
    scale, suffix = (7.0, ".tif") if kind.dtype == "float32" else (1.0, ".png")
    write_image(f"in{suffix}", texture(len(kind.channels)) * scale, kind)
    assert main(["animate", f"in{suffix}", "--flow", "sink", *QUICK, "--frames", "2", "-o", "out"]) == 0
    made, source = read_image(f"out/000001{suffix}"), read_image(f"in{suffix}")
    assert made.kind == kind
    assert abs(float(made.pixels.mean() - source.pixels.mean())) < 0.1 * scale


def test_a_video_of_floats_goes_from_their_least_to_their_largest(folder: Path) -> None:
    exemplar = texture(3) * 7 - 2
    write_image("in.tif", exemplar, Kind("float32", RGB.channels))
    for output in ("out.mp4", "out"):
        assert main(["animate", "in.tif", "--flow", "sink", *QUICK, "--frames", "2", "-o", output]) == 0
    values = torch.stack([read_image(path).pixels for path in sorted(Path("out").glob("*.tif"))], 1)
    shown = (values - exemplar.min()) / (exemplar.max() - exemplar.min())
    assert float(read_video("out.mp4").frames.mean()) == pytest.approx(float(shown.mean()), abs=0.02)


def test_a_loop_has_its_frames(folder: Path) -> None:
    assert main([*SAND, "--loop", "4", "-o", "out"]) == 0
    frames = frames_of("out")
    assert len(frames) == 4
    assert len(set(frames)) == 4


def test_the_first_frame_may_be_given(folder: Path) -> None:
    write_image("start.png", texture(size=96)[:, :50, :60], GRAY)
    assert main(["animate", "sand.png", "--flow", "sink", "--first", "start.png", "--frames", "1", "-o", "out"]) == 0
    made = read_image("out/000000.png").pixels
    assert made.shape == (1, 50, 60)
    close, other = read_image("start.png").pixels, read_image("start.png").pixels.roll((9, 9), (1, 2))
    assert float((made - close).square().mean()) < 0.7 * float((made - other).square().mean())


def test_texture_enters_an_empty_frame(folder: Path) -> None:
    arguments = ["animate", "sand.png", "--flow", "uniform", "--speed", "4", "--fill-from", "left", *QUICK]
    assert main([*arguments, "--frames", "4", "-o", "out"]) == 0
    first, last = (read_image(f"out/{number:06d}.png").pixels[0] for number in (0, 3))
    assert float(first.max()) == 0
    assert float((last[:, :12] > 0).float().mean()) > 0.9
    assert float(last[:, 12:].max()) == 0


@pytest.mark.parametrize("drawn", [False, True])
def test_the_obstacle_is_gray_and_nothing_flows_into_it(folder: Path, drawn: bool) -> None:
    mask = flow.disc_mask(SHAPE, (20.0, 15.0), 8.0)
    write_image("stone.png", (~mask).float()[None], GRAY)
    obstacle = "stone.png" if drawn else "disc:20,15,8"
    arguments = ["animate", "sand.png", "--flow", "uniform", "--obstacle", obstacle, "--preset", "fast"]
    assert main([*arguments, "--size", "48x40", "--frames", "2", "-o", "out"]) == 0
    made = read_array("out/000001.png")[0][..., 0]
    assert (made[~mask.numpy()] == 128).all()
    assert (made[mask.numpy()] != 128).mean() > 0.9
    pixels = read_image("sand.png").pixels
    bent = flow.around(flow.uniform(), mask)
    settings = {"mask": mask, "renewing": flow.PRESETS["fast"], "synthesis": PRESETS["fast"][0], "frames": 2}
    low, high = float(pixels.min()), float(pixels.max())
    *_, last = flow.animate(Exemplar.of((pixels - low) / (high - low)), bent, SHAPE, **settings)
    expected = (last.image * (high - low) + low)[0][mask]
    torch.testing.assert_close(torch.from_numpy(made)[mask] / 255, expected, rtol=0, atol=0.51 / 255)


def test_what_is_empty_is_transparent_where_there_is_alpha(folder: Path) -> None:
    pixels = torch.cat([texture(3), torch.ones(1, 64, 64)])
    write_image("in.png", pixels, Kind("uint8", ("R", "G", "B", "A")))
    arguments = ["animate", "in.png", "--flow", "uniform", "--obstacle", "disc", "--fill-from", "left", *QUICK]
    assert main([*arguments, "--frames", "2", "-o", "out"]) == 0
    assert not read_array("out/000000.png")[0].any()
    made = read_array("out/000001.png")[0]
    assert (made[:, 0, 3] == 255).mean() > 0.9
    assert not made[:, 10:].any()


def test_a_flow_of_another_size_is_stretched_on_request(folder: Path) -> None:
    arguments = ["animate", "sand.png", "--flow", "wind.flo", "--frames", "2", *QUICK]
    assert main([*arguments, "-o", "out", "--resample", "--speed", "2"]) == 0
    assert read_image("out/000001.png").pixels.shape == (1, *SHAPE)


# ---- going on


@pytest.mark.parametrize(
    ("length", "name", "after"), [("--frames", "animate", 1), ("--frames", "animate", 3), ("--loop", "loop", 4)]
)
def test_a_resumed_run_gives_the_same_bits(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    length: str,
    name: str,
    after: int,
) -> None:
    command = ["animate", "sand.png", "--flow", "waves", *QUICK, length, "6"]
    assert main([*command, "-o", "whole"]) == 0
    with monkeypatch.context() as patch:
        interrupted(patch, name, after)
        capsys.readouterr()
        assert main([*command, "-o", "parts"]) == 130
    sentence = f"kwatra: interrupted with {after} of 6 frames whole in parts; --resume goes on\n"
    assert capsys.readouterr() == ("", sentence)
    assert frames_of("parts") == frames_of("whole")[:after]
    assert main([*command, "-o", "parts", "--resume"]) == 0
    assert f"6 frames of 48x40, {6 - after} of them now," in capsys.readouterr().out
    assert frames_of("parts") == frames_of("whole")


@pytest.mark.parametrize("name", ["out.mp4", "out.gif"])
def test_a_resumed_video_is_the_same_file(folder: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    assert main([*SAND, "--frames", "4", "-o", f"whole_{name}"]) == 0
    with monkeypatch.context() as patch:
        interrupted(patch, "animate", 2)
        assert main([*SAND, "--frames", "4", "-o", name]) == 130
    assert not Path(name).exists()
    assert len(frames_of(f"{name}.frames")) == 2
    assert main([*SAND, "--frames", "4", "-o", name, "--resume"]) == 0
    assert Path(name).read_bytes() == Path(f"whole_{name}").read_bytes()
    assert not Path(f"{name}.frames").exists()


def test_an_interrupt_while_the_video_is_written_loses_no_frame(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("synth.io.videos._save_mp4", interrupt)
        assert main([*SAND, "--frames", "2", "-o", "out.mp4"]) == 130
    assert {path.name for path in folder.iterdir()} == {"sand.png", "wind.flo", "out.mp4.frames"}
    monkeypatch.setattr(flow, "animate", lambda *_, **named: iter(()) if named["after"].number == 1 else None)
    assert main([*SAND, "--frames", "2", "-o", "out.mp4", "--resume"]) == 0
    assert read_video("out.mp4").frames.shape == (3, 2, *SHAPE)


def test_resuming_nothing_begins(folder: Path) -> None:
    assert main([*SAND, "--frames", "2", "-o", "whole"]) == 0
    Path("empty").mkdir()
    for name in ("new", "empty"):
        assert main([*SAND, "--frames", "2", "-o", name, "--resume"]) == 0
        assert frames_of(name) == frames_of("whole")


@pytest.mark.parametrize("option", [[], ["--resume"], ["--overwrite"]])
@pytest.mark.parametrize("name", ["parts", "out.mp4"])
def test_a_process_killed_during_its_first_frame_is_no_dead_end(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, option: list[str]
) -> None:
    class Killed(BaseException):
        pass

    def kill(self: object, pixels: object, state: object) -> None:
        self.path.joinpath("000000.png").write_bytes(b"of a state that was never written")
        self.path.joinpath(".kwatra-0123456789abcdef.npz").write_bytes(b"half a sta")
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr("synth.io.frames.FramesFolder.add", kill)
        with pytest.raises(Killed):
            main([*SAND, "--frames", "2", "-o", name])
    assert main([*SAND, "--frames", "2", "-o", name, *option]) == 0
    assert (read_video(name).frames.shape[1], Path("out.mp4.frames").exists()) == (2, False)


def test_more_frames_may_be_asked_for_and_a_finished_folder_needs_none(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SAND, "--frames", "4", "-o", "whole"]) == 0
    assert main([*SAND, "--frames", "2", "-o", "parts"]) == 0
    assert main([*SAND, "--frames", "4", "-o", "parts", "--resume"]) == 0
    assert frames_of("parts") == frames_of("whole")
    before = contents(folder)
    capsys.readouterr()
    assert main([*SAND, "--frames", "4", "-o", "parts", "--resume"]) == 0
    assert capsys.readouterr().out == "parts has its 4 frames already; there is nothing to do\n"
    assert contents(folder) == before


def test_a_process_killed_between_frame_and_state_leaves_nothing_wrong(folder: Path) -> None:
    assert main([*SAND, "--frames", "3", "-o", "whole"]) == 0
    assert main([*SAND, "--frames", "2", "-o", "parts"]) == 0
    Path("parts/000002.png").write_bytes(b"of a state that was never written")
    Path("parts/.kwatra-0123456789abcdef.png").write_bytes(b"half a fra")
    Path("parts/.kwatra-0123456789abcdee.npz").write_bytes(b"half a sta")
    assert main([*SAND, "--frames", "3", "-o", "parts", "--resume"]) == 0
    assert contents(folder / "parts").keys() == {folder / "parts" / name for name in os.listdir("whole")}
    assert frames_of("parts") == frames_of("whole")


def test_overwriting_begins_when_the_first_new_frame_is_there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert main([*SAND, "--frames", "3", "-o", "out"]) == 0
    before = contents(folder)
    with monkeypatch.context() as patch:
        interrupted(patch, "animate", 0)
        assert main([*SAND, "--frames", "2", "--seed", "1", "-o", "out", "--overwrite"]) == 130
    assert contents(folder) == before
    assert main([*SAND, "--frames", "2", "--seed", "1", "-o", "out", "--overwrite"]) == 0
    assert sorted(os.listdir("out")) == [".state.npz", "000000.png", "000001.png"]
    assert before[folder / "out" / "000000.png"] != frames_of("out")[0]


def test_ctrl_c_in_a_process(folder: Path) -> None:
    program = """
import signal, sys
from contextlib import contextmanager
from synth import cli
from synth.commands import animate as animate_command
signal.signal(signal.SIGINT, signal.default_int_handler)
@contextmanager
def announce(title):
    yield lambda what, part: print(what, flush=True)
animate_command.work_line = announce
sys.exit(cli.main(sys.argv[1:]))
"""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, "-c", program, *SAND, "--frames", "100000", "-o", "out.mp4"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline().startswith("frame 1 of 100000, ")
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
        error = process.stderr.read()
    count = len(frames_of("out.mp4.frames"))
    assert error == f"kwatra: interrupted with {count} of 100000 frames whole in out.mp4.frames; --resume goes on\n"
    assert all(read_image(path).pixels.shape == (1, *SHAPE) for path in Path("out.mp4.frames").glob("[0-9]*"))
    assert {path.name for path in folder.iterdir()} == {"sand.png", "wind.flo", "out.mp4.frames"}


# ---- what it refuses


def test_a_folder_from_other_settings(folder: Path, refused: Callable[..., str]) -> None:
    write_image("start.png", texture(size=96)[:, :40, :48], GRAY)
    assert main([*SAND, "--frames", "2", "-o", "out"]) == 0
    for changed, sentence in (
        ("--flow sink", "another --flow;"),
        ("--speed 1 --seed 1", "another --speed and another --seed; give the same again, or begin anew"),
        ("--size 48x42", "another --size;"),
        ("--preset default", "another --preset;"),
        ("--obstacle disc", "another --obstacle;"),
        ("--fill-from left", "another --fill-from;"),
        ("--first start.png", "another --first;"),
        ("--frames 1", "out has 2 frames already, more than the 1 asked for; give --frames 2 or more"),
    ):
        assert sentence in refused(*but([*SAND, "--frames", "2", "-o", "out"], changed), "--resume")


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
        ("--flow rotation --speed 99", "beyond the 48x40 frame; give a lower speed"),
        ("--flow rotation --speed nan", "a flow's speed is nan"),
        ("--flow cut.flo", "cut.flo has 4000 bytes"),
        ("--flow magic.flo", "magic.flo is no Middlebury flow"),
        ("--flow wind.flo", "wind.flo is 36x30 but the frames are to be 48x40; leave out --size, or stretch it with"),
        ("--obstacle all.png", "all.png covers the whole frame"),
        ("--obstacle none.png", "none.png leaves the whole frame free"),
        ("--obstacle sand.png", "sand.png is 64x64 but the frames are to be 48x40"),
        ("--obstacle disc:1,1,99", "the disc covers the whole frame"),
        ("--obstacle disc:900,1,9", "the disc leaves the whole frame free"),
        ("--obstacle disc:1,1", "'disc:1,1' is no disc; write disc, or disc:X,Y,RADIUS"),
        ("--frames 0", "'0' is no whole number from 1 on"),
        ("--loop 1", "'1' is no whole number from 2 on"),
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


# ---- videos


@pytest.fixture
def clip(folder: Path) -> torch.Tensor:
    """Frames (1, 5, 40, 48) of a texture that changes in place, as a folder, living."""
    start, end = (texture(size=48)[:, :40], texture(size=48).flip(2)[:, :40])
    frames = torch.stack([torch.lerp(start, end, t / 4) for t in range(5)], 1)
    write_video("living", frames, 10.0, GRAY)
    return frames


VIDEO = ["animate", "living", "--flow", "rotation", "--preset", "fast", "--speed", "1"]


def test_a_video_is_animated_at_its_own_size_and_rate(clip: torch.Tensor, folder: Path) -> None:
    write_video("living.gif", clip, 10.0)
    assert main([*VIDEO, "--frames", "3", "-o", "out"]) == 0
    read = read_video("living").frames
    low, high = float(read.min()), float(read.max())
    expected = flow.animate(
        ((read.double() - low) / (high - low)).float(), flow.rotation(1.0), SHAPE, frames=3,
        renewing=flow.VIDEO_PRESETS["fast"], synthesis=PRESETS["fast"][0],
    )  # fmt: skip
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main(["animate", "living.gif", *VIDEO[2:], "--frames", "2", "-o", "out.mp4"]) == 0
    assert read_video("out.mp4").rate == pytest.approx(10.0)


@pytest.mark.parametrize("name", ["sand.png", "living"])
def test_copies_of_the_exemplar_are_used_on_request(clip: torch.Tensor, folder: Path, name: str) -> None:
    command = ["animate", name, "--flow", "rotation", "--preset", "fast", "--size", "48x40", "--frames", "2"]
    assert main([*command, "--mirror", "--rotate=90,180", "--scale", "0.8", "-o", "out"]) == 0
    pixels = read_image(name).pixels if name.endswith("png") else read_video(name).frames
    low, high = float(pixels.min()), float(pixels.max())
    exemplar = Exemplar.of(((pixels.double() - low) / (high - low)).float(), mirror=True, rotate=(90, 180), scale=[0.8])
    presets = flow.PRESETS if pixels.ndim == 3 else flow.VIDEO_PRESETS
    expected = flow.animate(exemplar, flow.rotation(2.0), SHAPE, frames=2, renewing=presets["fast"],
                            synthesis=PRESETS["fast"][0])  # fmt: skip
    for number, frame in enumerate(expected):
        made = read_image(f"out/{number:06d}.png")
        torch.testing.assert_close(made.pixels, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main([*command[:-1], "3", "-o", "out", "--resume"]) == 2


def test_maps_of_directions_are_not_turned_with_copies(clip: torch.Tensor, folder: Path, capsys) -> None:
    write_video("normals", clip, 10.0, GRAY)
    assert main([*VIDEO, "--also", "normal=normals", "--mirror", "-o", "out"]) == 2
    assert "--also normal holds directions" in capsys.readouterr().err


def test_a_video_is_gone_on_with_and_loops(clip: torch.Tensor, folder: Path) -> None:
    assert main([*VIDEO, "--frames", "4", "-o", "whole"]) == 0
    assert main([*VIDEO, "--frames", "2", "-o", "part"]) == 0
    assert main([*VIDEO, "--frames", "4", "-o", "part", "--resume"]) == 0
    assert frames_of("part") == frames_of("whole")
    assert main([*VIDEO, "--loop", "4", "-o", "round"]) == 0
    assert main([*VIDEO, "--frames", "3", "--fill-from", "all", "--obstacle", "disc", "-o", "wet"]) == 0


def test_a_video_that_cannot_be_read_is_refused(
    clip: torch.Tensor, folder: Path, capsys: pytest.CaptureFixture
) -> None:
    write_video("one", clip[:, :1], 10.0, GRAY)
    assert main(["animate", "one", "--flow", "rotation"]) == 2
    assert "has 1 frame but a video needs at least 2" in capsys.readouterr().err
    Path("none").mkdir()
    assert main(["animate", "none", "--flow", "rotation"]) == 2
    assert "none holds no images" in capsys.readouterr().err


def test_a_video_flows_as_published(
    clip: torch.Tensor, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["animate", "living", "--flow", "uniform:90", "--speed", "1", "--size", "24x24", "--published"]
    assert main([*command, "--frames", "4", "-o", "whole"]) == 0
    read = read_video("living").frames
    low, high = float(read.min()), float(read.max())
    for number, frame in enumerate(
        flow.published(((read.double() - low) / (high - low)).float(), flow.uniform(1.0, 90), (24, 24), 4)
    ):
        made = read_image(f"whole/{number:06d}.png").pixels
        torch.testing.assert_close(made, frame.image * (high - low) + low, rtol=0, atol=0.51 / 255)
    assert main([*command, "--frames", "4", "--rotate", "90", "-o", "turned"]) == 0
    assert frames_of("turned") != frames_of("whole")
    with monkeypatch.context() as patch:
        interrupted(patch, "published", 2)
        assert main([*command, "--frames", "4", "-o", "part"]) == 130
    assert len(frames_of("part")) == 2
    assert main([*command, "--frames", "4", "-o", "part", "--resume"]) == 0
    assert frames_of("part") == frames_of("whole")
    capsys.readouterr()
    for more, said in (
        (["--preset", "fast"], "--preset says how to renew, but what was --published renews nothing"),
        (["--fill-from", "left"], "--fill-from begins an animation, but what was --published has no such"),
    ):
        assert main([*command, *more]) == 2
        assert said in capsys.readouterr().err
    assert main(["animate", "sand.png", "--flow", "rotation", "--published", "--loop", "4"]) == 2
    assert "neither loops nor flows around obstacles" in capsys.readouterr().err
