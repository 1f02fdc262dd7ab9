"""What all commands have in common: names, folders, one output per file, sizes that tile, what they tell."""

import io
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from kwatra import Progress
from synth import Kind, read_image, write_image
from synth.cli import main
from synth.commands import parsing, progress
from synth.commands.telling import contributions
from synth.io.images import read_array
from synth.saying import note

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))
FAST = ["--preset", "fast", "--size", "40x40"]


def noise(channels: int, seed: int = 0, size: int = 24) -> torch.Tensor:
    return torch.rand(channels, size, size, generator=torch.Generator().manual_seed(seed))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder with two exemplars, a texture of dots, and a folder."""
    monkeypatch.chdir(tmp_path)
    write_image("a.png", noise(3) * 0.4, RGB)
    write_image("b.png", noise(3, 1) * 0.4 + 0.6, RGB)
    y, x = np.mgrid[:64, :60]
    write_image("dots.png", torch.from_numpy((np.hypot(y % 16 - 8, x % 20 - 10) < 5) * 1.0)[None].float(), GRAY)
    Path("made").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (["synth", "a.png", *FAST], "a_synth.png"),
        (["quilt", "a.png", "--refine", "0"], "a_quilt.png"),
        (["tile", "a.png"], "a_tile.png"),
    ],
)
def test_a_folder_as_output_takes_the_file(folder: Path, command: list[str], name: str) -> None:
    assert main([*command, "-o", "made/"]) == 0
    assert [path.name for path in Path("made").iterdir()] == [name]


def test_each_exemplar_has_an_output_of_its_own(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["synth", "a.png", "b.png", "--each", "-o", "made", *FAST]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines] == ["wrote made/a_synth.png", "wrote made/b_synth.png"]
    assert float(read_image("made/a_synth.png").pixels.max()) < 0.41
    assert float(read_image("made/b_synth.png").pixels.min()) > 0.59


def test_of_several_exemplars_it_says_what_each_gave(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = np.array([[0, 0, 0, 2], [-1, 0, 0, 0]])
    names = [Path("in/a.png"), Path("b.png"), Path("c.png")]
    assert contributions(names, source) == "; of it a.png 75%, b.png nothing, c.png 12%"
    assert contributions(names[:1], source) == ""
    assert main(["synth", "a.png", "b.png", "--map", "m.npy", *FAST]) == 0
    told = capsys.readouterr().out.rstrip().partition(" (0 is best)")[2]
    assert told == contributions([Path("a.png"), Path("b.png")], np.load("m.npy")[0])


def test_each_is_refused_what_belongs_to_one_output(folder: Path, refused: Callable[..., str]) -> None:
    several = ("synth", "a.png", "b.png", "--each", *FAST)
    assert "--map belongs to one output but --each makes several" in refused(*several, "--map", "m.npy")
    assert "--also belongs to one output" in refused(*several, "--also", "n=a.png")
    assert "c.png is no folder; name one that exists" in refused(*several, "-o", "c.png")
    assert "two exemplars are called a" in refused("synth", "a.png", "a.png", "--each", *FAST)
    Path("a_synth.png").touch()
    assert "a_synth.png exists" in refused("synth", "b.png", "a.png", "--each", *FAST)


def test_details_are_told_when_asked_for(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["synth", "a.png", "--verbose", *FAST]) == 0
    told = capsys.readouterr().out
    assert f"  file           {folder.resolve() / 'a_synth.png'}\n" in told
    for word in ("levels", "energy", "ended because", "quality        overall 0."):
        assert f"\n  {word}" in told
    assert main(["quilt", "a.png", "--refine", "1", "--verbose"]) == 0
    assert "\n  seams cost     " in capsys.readouterr().out


def test_sizes_without_whole_periods_are_told_of_or_made_good(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["synth", "dots.png", "--preset", "fast", "--size", "71x70", "--overwrite"]
    assert main([*command, "--tile"]) == 0
    assert "71x70 holds no whole periods of this texture, which will show; 80x64 does" in capsys.readouterr().err
    assert main([*command, "--tile", "nearest"]) == 0
    out, err = capsys.readouterr()
    assert "80x64, seed 0" in out
    assert err == ""
    made = read_array("dots_synth.png")[0]
    assert np.mean(np.roll(made, (16, 20), (0, 1)) != made) < 0.02
    assert main(["synth", "--tile", "dots.png", "--preset", "fast", "--size", "40x32", "--overwrite"]) == 0
    assert capsys.readouterr().err == ""
    assert main(["quilt", "dots.png", "--tile", "nearest", "--size", "45x45", "--refine", "0"]) == 0
    assert read_image("dots_quilt.png").pixels.shape == (1, 48, 40)


def test_a_given_size_and_the_nearest_one_contradict(folder: Path, refused: Callable[..., str]) -> None:
    assert "--tile nearest chooses a size" in refused("synth", "a.png", "--start", "a.png", "--tile", "nearest")


def test_merging_mixed_kinds_loses_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deep = torch.linspace(0, 65535, 576).round().view(1, 24, 24) / 65535
    write_image("deep.png", deep, Kind("uint16", ("Y",)))
    write_image("keep.png", torch.ones(1, 24, 24), GRAY)
    assert main(["merge", "a.png", "deep.png", "--keep", "keep.png"]) == 0
    merged, kind = read_array("a_merge.png")
    assert kind == Kind("uint16", ("R", "G", "B"))
    assert np.array_equal(merged, np.repeat(read_array("deep.png")[0], 3, 2))
    out, err = capsys.readouterr()
    assert "; of it a.png nothing, deep.png 100%" in out
    assert "deep.png covers nearly all that it lies on; mark with --spare what is to show the background" in err
    write_image("bright.exr", noise(3) * 9, Kind("float16", ("R", "G", "B")))
    assert main(["merge", "bright.exr", "deep.png", "--keep", "keep.png", "--at", "12,0"]) == 0
    assert float(read_image("bright_merge.exr").pixels.max()) > 8


def test_what_cannot_hold_the_richer_kind_is_refused(folder: Path, refused: Callable[..., str]) -> None:
    write_image("bright.exr", noise(3) * 9, Kind("float16", ("R", "G", "B")))
    message = refused("merge", "a.png", "bright.exr", "--keep", "a.png")
    assert "a_merge.png has an ending that cannot hold float16 RGB pixels" in message


def test_exemplars_are_raised_to_the_richest(folder: Path) -> None:
    alpha = torch.cat([noise(1), torch.full((1, 24, 24), 0.5)])
    write_image("clear.png", alpha, Kind("uint16", ("Y", "A")))
    assert main(["synth", "a.png", "clear.png", "--map", "m.npy", "--seed", "1", *FAST]) == 0
    made, kind = read_array("a_synth.png")
    assert kind == Kind("uint16", ("R", "G", "B", "A"))
    assert set(np.unique(made[..., 3][np.load("m.npy")[0] == 0])) == {65535}


def test_scales_are_read_in_one_way() -> None:
    assert parsing.scales("0.8,1.25") == (0.8, 1.25)
    assert parsing.scales("0.5:2") == pytest.approx((0.5, 0.7071, 1, 1.4142, 2), rel=1e-4)
    assert parsing.scales("2:2") == (2.0,)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_command_says_at_once_that_it_works_and_a_bar_takes_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.working("synth"):
        assert terminal.getvalue() == "\rkwatra synth: at work"
        with progress.work_line("title"):
            deadline = time.monotonic() + 1.3
            while time.monotonic() < deadline:
                time.sleep(0.05)
        assert "at work for" not in terminal.getvalue()
        deadline = time.monotonic() + 10
        while "at work for" not in terminal.getvalue() and time.monotonic() < deadline:
            time.sleep(0.01)
        note("a hint")
    assert "kwatra synth: at work for" in terminal.getvalue()
    assert "\r\x1b[Kkwatra: note: a hint\n" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")


def test_what_is_no_terminal_hears_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress.working("synth"):
        pass
    assert sys.stderr.getvalue() == ""  # type: ignore[attr-defined]


def test_a_try_of_several_is_named_and_the_bar_never_runs_back(monkeypatch: pytest.MonkeyPatch) -> None:
    image = torch.zeros(1, 1, 1)
    assert progress.place_of(Progress(0.3, 1, 1, 0.0, image)) == "level 2"
    assert progress.place_of(Progress(0.3, 0, 1, 0.0, image, 2, 6)) == "try 2 of 6, level 1"
    shown: list[float] = []
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.progress_line("title") as show:
        from rich.progress import Progress as Bar

        update = Bar.update

        def spied(self: Bar, *rest: Any, **named: Any) -> None:
            shown.append(named["completed"])
            update(self, *rest, **named)

        monkeypatch.setattr(Bar, "update", spied)
        for fraction in (0.1, 0.5, 0.4, 0.8):
            show(Progress(fraction, 0, 1, 0.0, image))
    assert shown == [0.1, 0.5, 0.5, 0.8]


def test_light_that_was_evened_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lit = noise(1, size=80) * torch.linspace(0.4, 1, 80)
    for name, picture in (("lit.png", lit), ("even.png", noise(1, size=80))):
        write_image(name, picture, GRAY)
        assert main(["synth", name, *FAST]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "_synth.png" in line]
    assert ["evened" in line for line in lines] == [True, False]
