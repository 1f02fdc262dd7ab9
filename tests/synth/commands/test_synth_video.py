"""`kwatra synth VIDEO`."""

import csv
from pathlib import Path

import numpy as np
import pytest
import torch

import synth
from synth.cli import main
from synth.io.videos import read_video, write_video
from synth.texture import stretch as plan


@pytest.fixture
def clip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of 8 frames of 24x20 in which blobs drift."""
    monkeypatch.chdir(tmp_path)
    field = torch.rand(3, 20, 24, generator=torch.Generator().manual_seed(2))
    smooth = torch.nn.functional.avg_pool2d(field.repeat(1, 3, 3), 5, 1, 2)[:, 20:40, 24:48]
    write_video("drops", torch.stack([smooth.roll(t, 1) for t in range(8)], 1), 25.0)
    return tmp_path


def frames(path: str) -> torch.Tensor:
    return read_video(path).frames


def test_a_folder_becomes_a_folder_twice_as_long(clip, capsys):
    assert main(["synth", "drops", "--preset", "fast", "--seed", "3"]) == 0
    assert "drops_synth: 16 frames of 24x20" in capsys.readouterr().out
    made = frames("drops_synth")
    assert made.shape == (3, 16, 20, 24)
    again = synth.synthesize(frames("drops"), (16, 20, 24), preset="fast", seed=3).image
    assert torch.equal(made, (again * 255).round() / 255)


def test_size_and_length_in_seconds_as_a_video(clip):
    arguments = ["synth", "drops", "--preset", "fast", "-o", "out.gif", "--size", "32x28", "--seconds", "0.5"]
    assert main([*arguments, "--fps", "10"]) == 0
    assert frames("out.gif").shape == (3, 5, 28, 32)
    assert not Path("out.gif.frames").exists()


def test_what_was_interrupted_is_resumed_to_the_same_bits(clip, monkeypatch, capsys):
    monkeypatch.setattr(plan, "VOXELS", 1)
    run = ["synth", "drops", "--preset", "fast", "--frames", "70"]
    assert main([*run, "-o", "whole"]) == 0
    from synth.io.frames import FramesFolder

    add = FramesFolder.add

    def interrupted(self, pixels, state):
        if state.number == 41:
            raise KeyboardInterrupt
        add(self, pixels, state)

    monkeypatch.setattr(FramesFolder, "add", interrupted)
    assert main([*run, "-o", "parts"]) == 130
    assert "41 of 70 frames whole in parts" in capsys.readouterr().err
    monkeypatch.setattr(FramesFolder, "add", add)
    assert main([*run, "-o", "parts", "--seed", "1", "--resume"]) == 2
    assert main([*run, "-o", "parts", "--resume"]) == 0
    assert torch.equal(frames("whole"), frames("parts"))


def test_maps_sources_and_energies_of_the_whole_run(clip, monkeypatch):
    monkeypatch.setattr(plan, "VOXELS", 1)
    heights = (torch.arange(8 * 20 * 24).view(1, 8, 20, 24) % 251 / 255.0).expand(3, -1, -1, -1)
    write_video("heights", heights, 25.0)
    run = ["synth", "drops", "--preset", "fast", "--frames", "60", "--map", "where.npy", "--energy", "energy.csv"]
    assert main([*run, "--also", "height=heights"]) == 0
    where = np.load("where.npy")
    assert where.shape == (4, 60, 20, 24)
    carried = frames("drops_synth_height")
    assert torch.equal(carried, heights[:, where[1], where[2], where[3]])
    rows = list(csv.DictReader(Path("energy.csv").read_text().splitlines()))
    assert {row["stretch"] for row in rows} == {str(number) for number in range(len({r["stretch"] for r in rows}))}
    assert len({row["stretch"] for row in rows}) > 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["drops", "--guide", "a=b"], "--guide is for images but drops is a video"),
        (["drops", "--start", "a.png"], "--start is for images"),
        (["drops", "--map", "a.npy", "--resume"], "--map tells of a whole run"),
        (["drops", "--stay", "1", "--tile"], "leave out stay, or tile"),
        (["drops", "--tile", "nearest"], "--tile nearest is for images"),
        (["drops", "--seconds", "0.001"], "less than a frame"),
        (["drops", "-o", "out.avi"], "no video can have"),
        (["drops", "--frames", "10000000000", "-o", "huge"], "are free; ask for fewer"),
        (["drops", "still.png"], "still.png is an image"),
        (["drops", "--also", "height"], "write NAME=VIDEO"),
        (["drops", "--also", "height=short"], "a map has its exemplar's"),
        (["still.png", "--loop"], "--loop is for videos but still.png is an image"),
        (["still.png", "--frames", "3"], "--frames is for videos"),
        (["still.png", "--resume"], "--resume is for videos"),
        (["empty"], "holds no images"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(clip, arguments, said, capsys):
    synth.write_image("still.png", torch.zeros(3, 20, 24), synth.Kind("uint8", ("R", "G", "B")))
    write_video("short", torch.zeros(3, 3, 20, 24), 25.0)
    Path("empty").mkdir()
    before = sorted(clip.rglob("*"))
    assert main(["synth", *arguments]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert sorted(clip.rglob("*")) == before


def test_an_existing_folder_is_replaced_only_when_asked(clip, capsys):
    run = ["synth", "drops", "--preset", "fast", "--frames", "3"]
    assert main(run) == 0
    assert main([*run, "--seed", "1"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    first = frames("drops_synth")
    assert main([*run, "--seed", "1", "--overwrite"]) == 0
    assert not torch.equal(frames("drops_synth"), first)


@pytest.mark.parametrize("arguments", [["--frames", "0"], ["--frames", "9", "--seconds", "1"], ["--stay", "-1"]])
def test_options_that_are_none_are_refused(clip, arguments):
    with pytest.raises(SystemExit) as error:
        main(["synth", "drops", *arguments])
    assert error.value.code == 2
