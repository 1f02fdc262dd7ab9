"""`kwatra animate`: a run can be gone on with, whatever ended it."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import contents
from sand import QUICK, SAND, SHAPE, frames_of, interrupted, written

import flow
from synth import read_image
from synth.cli import main
from synth.io.videos import read_video


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with an exemplar and a flow."""
    monkeypatch.chdir(tmp_path)
    written()
    return tmp_path


@pytest.mark.parametrize(("length", "name", "after"), [("--frames", "animate", 2), ("--loop", "loop", 4)])
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
        patch.setattr("synth.io.videos.save_mp4", interrupt)
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


@pytest.mark.parametrize(
    ("name", "option"),
    [("parts", []), ("parts", ["--resume"]), ("parts", ["--overwrite"]), ("out.mp4", []), ("out.mp4", ["--resume"])],
)
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
