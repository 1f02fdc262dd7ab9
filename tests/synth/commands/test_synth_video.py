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


@pytest.mark.parametrize("length", [1, 2, 3])
def test_short_clips_are_legal(clip, length):
    short = frames("drops")[:, :length]
    write_video("short", short, 25.0)
    assert main(["synth", "short", "-o", "out", "--frames", "5", "--preset", "fast", "--map", "map.npy"]) == 0
    made, source = frames("out"), np.load("map.npy")
    assert made.shape == (3, 5, 20, 24)
    copied = short[:, *source[1:]]  # but for light, which goes on where pieces meet
    assert float((made - copied).abs().mean()) < 0.05


def test_a_folder_becomes_a_folder_twice_as_long(clip, capsys):
    assert main(["synth", "drops", "--preset", "fast", "--seed", "3"]) == 0
    assert "drops_synth: 16 frames of 24x20" in capsys.readouterr().out
    made = frames("drops_synth")
    assert made.shape == (3, 16, 20, 24)
    again = synth.synthesize(frames("drops"), (16, 20, 24), preset="fast", seed=3).image
    assert torch.equal(made, (again * 255).round() / 255)


def test_clips_and_their_maps_are_raised_to_the_richest(clip):
    deep = synth.Kind("uint16", ("Y", "A"))
    write_video("clear", torch.cat([frames("drops")[:1], torch.full((1, 8, 20, 24), 0.9)]), 25.0, deep)
    write_video("gray", frames("drops")[:1], 25.0, synth.Kind("uint8", ("Y",)))
    run = ["synth", "drops", "clear", "--also", "map=drops,gray", "--preset", "fast", "--size", "48x40", "-o", "out"]
    assert main([*run, "--map", "map.npy"]) == 0
    made, first = read_video("out"), np.load("map.npy")[0] == 0
    assert made.kind == synth.Kind("uint16", ("R", "G", "B", "A"))
    for own, alpha in ((first, 1.0), (~first, 0.9)):  # but for light, which goes on where pieces meet
        assert float((made.frames[3][own] - alpha).abs().mean()) < 0.04
    assert read_video("out_map").kind == synth.Kind("uint8", ("R", "G", "B"))


def test_size_and_length_in_seconds_as_a_video(clip):
    arguments = ["synth", "drops", "--preset", "fast", "-o", "out.gif", "--size", "32x28", "--seconds", "0.5"]
    assert main([*arguments, "--fps", "10"]) == 0
    assert frames("out.gif").shape == (3, 5, 28, 32)
    assert not Path("out.gif.frames").exists()


def test_what_was_interrupted_is_resumed_to_the_same_bits(clip, monkeypatch, capsys):
    monkeypatch.setattr(plan, "VOXELS", 1)
    run = ["synth", "drops", "--preset", "fast", "--frames", "36"]
    assert main([*run, "-o", "whole"]) == 0
    from synth.io.frames import FramesFolder

    add = FramesFolder.add

    def interrupted(self, pixels, state):
        if state.number == 25:
            raise KeyboardInterrupt
        add(self, pixels, state)

    monkeypatch.setattr(FramesFolder, "add", interrupted)
    assert main([*run, "-o", "parts"]) == 130
    assert "25 of 36 frames whole in parts" in capsys.readouterr().err
    monkeypatch.setattr(FramesFolder, "add", add)
    assert main([*run, "-o", "parts", "--seed", "1", "--resume"]) == 2
    assert main([*run, "-o", "parts", "--map", "where.npy", "--resume"]) == 2
    assert "--map tells of a whole run but parts holds 25 frames of it already" in capsys.readouterr().err
    assert main([*run, "-o", "parts", "--resume"]) == 0
    assert torch.equal(frames("whole"), frames("parts"))


def test_maps_sources_and_energies_of_the_whole_run(clip, monkeypatch):
    monkeypatch.setattr(plan, "VOXELS", 1)
    heights = (torch.arange(8 * 20 * 24).view(1, 8, 20, 24) % 251 / 255.0).expand(3, -1, -1, -1)
    write_video("heights", heights, 25.0)
    run = ["synth", "drops", "--preset", "fast", "--frames", "36", "--map", "where.npy", "--energy", "energy.csv"]
    assert main([*run, "--also", "height=heights", "--resume"]) == 0  # of which nothing is there to go on with
    where = np.load("where.npy")
    assert where.shape == (4, 36, 20, 24)
    carried = frames("drops_synth_height")
    assert torch.equal(carried, heights[:, where[1], where[2], where[3]])
    rows = list(csv.DictReader(Path("energy.csv").read_text().splitlines()))
    assert {row["stretch"] for row in rows} == {str(number) for number in range(len({r["stretch"] for r in rows}))}
    assert len({row["stretch"] for row in rows}) > 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["drops", "--guide", "still.png"], "write EXEMPLAR_MAP=OUTPUT_MAP"),
        (["drops", "--guide-weight", "2"], "there is none"),
        (["drops", "--guide", "short=drops"], "short is 3 frames of 24x20 but its exemplar 8 frames of 24x20"),
        (["drops", "--start", "drops", "--frames", "9"], "--start is 8 frames of 24x20 but the output has 9"),
        (["drops", "--start", "still.png", "--size", "30x20"], "--start is 24x20 but the output 30x20"),
        (["drops", "--start", "drops", "--keep", "short=mask.png"], "--keep is 3 frames of 24x20"),
        (["drops", "--keep", "still.png"], "does not say which pixels"),
        (["drops", "--mask", "gone"], "gone"),
        (["drops", "--exemplar-mask", "short"], "short is 3 frames of 24x20 but its exemplar"),
        (["drops", "--mask", "mask.png", "--frames", "9000000"], "made as a whole"),
        (["drops", "--each"], "--each is for images but drops is a video"),
        (["drops", "--stay", "1", "--tile"], "leave out stay, or tile"),
        (["drops", "--tile", "nearest"], "--tile nearest is for images"),
        (["drops", "--seconds", "0.001"], "less than a frame"),
        (["drops", "--seconds", "1e308"], "1e+308 seconds are more than 1000000000000 frames"),
        (["drops", "-o", "out.avi"], "no video can have"),
        (["drops", "--frames", "10000000000", "-o", "huge"], "are free; ask for fewer"),
        (["drops", "still.png"], "still.png is an image"),
        (["drops", "--also", "height"], "write NAME=VIDEO"),
        (["drops", "--also", "height=short"], "a map has its exemplar's"),
        (["still.png", "--loop"], "--loop is for videos but still.png is an image"),
        (["still.png", "--frames", "3"], "--frames is for videos"),
        (["still.png", "--resume"], "--resume is for videos"),
        (["empty"], "holds no images"),
        (["still.gif"], "still.gif is a still picture but GIF is read as video; convert it to PNG"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(clip, arguments, said, capsys):
    synth.write_image("still.png", torch.zeros(3, 20, 24), synth.Kind("uint8", ("R", "G", "B")))
    synth.write_image("mask.png", torch.ones(3, 20, 24), synth.Kind("uint8", ("R", "G", "B")))
    write_video("short", torch.zeros(3, 3, 20, 24), 25.0)
    write_video("still.gif", torch.zeros(3, 1, 20, 24), 25.0)
    Path("empty").mkdir()
    before = sorted(clip.rglob("*"))
    assert main(["synth", *arguments]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert sorted(clip.rglob("*")) == before


def still(name: str, pixels: torch.Tensor) -> None:
    synth.write_image(name, pixels, synth.Kind("uint8", ("R", "G", "B")), overwrite=True)


def test_pixels_to_keep_are_kept_and_masked_ones_empty_in_all_frames(clip):
    picture = (torch.arange(3 * 20 * 24).view(3, 20, 24) % 253) / 255
    where, belongs = torch.zeros(3, 20, 24), torch.ones(3, 20, 24)
    where[:, 4:9, 5:11], belongs[:, :, 20:] = 1, 0
    still("logo.png", picture)
    still("where.png", where)
    still("belongs.png", belongs)
    run = ["synth", "drops", "--preset", "fast", "--frames", "5", "--keep", "logo.png=where.png"]
    assert main([*run, "--mask", "belongs.png", "--seed", "2"]) == 0
    made, there = frames("drops_synth"), where[0] > 0
    assert torch.equal(made[:, :, there], picture[:, None].expand(-1, 5, -1, -1)[:, :, there])
    assert float(made[:, :, :, 20:].amax() - made[:, :, :, 20:].amin()) == 0
    assert made[:, :, 10:, :20].std() > 0.75 * frames("drops").std()


def test_a_start_and_soft_pixels_of_videos_say_the_length_and_are_followed(clip):
    wanted = torch.stack([frames("drops")[:, t].roll(5, 1) for t in range(6)], 1)
    write_video("wanted", wanted, 25.0)
    white = torch.ones(3, 20, 24)
    still("white.png", white)

    def apart(*options: str) -> float:
        assert main(["synth", "drops", "--preset", "fast", "--overwrite", "--stay", "0", *options]) == 0
        made = frames("drops_synth")
        assert made.shape[1] == 6
        return float((made - wanted).abs().mean())

    free = apart("--frames", "6")
    assert apart("--soft", "wanted=white.png", "--soft-weight", "10") < 0.3 * free
    assert apart("--start", "wanted") < 0.5 * free


def test_guides_of_stills_and_videos_and_where_may_be_copied(clip):
    labels = torch.zeros(3, 20, 24)
    labels[:, :, 12:] = 1
    still("labels.png", labels)
    black = torch.zeros(3, 20, 24)
    write_video("turning", torch.stack([black] * 4 + [1 - black] * 4, 1), 25.0)
    run = ["synth", "drops", "--preset", "fast", "--overwrite", "--stay", "0", "--map", "where.npy"]
    assert main([*run, "--guide", "labels.png=turning", "--guide-weight", "3"]) == 0
    columns = np.load("where.npy")[3]
    assert columns.shape == (8, 20, 24)
    assert (columns[:3] < 12).mean() > 0.9
    assert (columns[5:] >= 12).mean() > 0.9
    assert main([*run, "--frames", "4", "--exemplar-mask", "labels.png"]) == 0
    assert np.load("where.npy")[3].min() >= 12


def test_a_drawing_says_how_light_and_dark_a_video_is_to_be(clip):
    labels = torch.zeros(3, 20, 24)
    labels[:, :, 12:] = 1
    still("mirrored.png", 1 - labels)
    write_video("shaded", frames("drops") * (0.25 + 0.75 * labels[:, None]), 25.0)
    assert main(["synth", "shaded", "--preset", "fast", "--stay", "0", "--guide", "tones=mirrored.png"]) == 0
    light = frames("shaded_synth").mean((0, 1, 2))
    assert float(light[:10].mean()) > 1.5 * float(light[14:].mean())


def test_what_is_asked_of_pixels_decides_the_frames_too(clip, monkeypatch, capsys):
    from synth.io.frames import FramesFolder

    add = FramesFolder.add

    def interrupted(self, pixels, state):
        if state.number == 3:
            raise KeyboardInterrupt
        add(self, pixels, state)

    still("one.png", torch.rand(3, 20, 24, generator=torch.Generator().manual_seed(1)))
    still("two.png", torch.rand(3, 20, 24, generator=torch.Generator().manual_seed(2)))
    run = ["synth", "drops", "--preset", "fast", "--frames", "6"]
    assert main([*run, "--start", "one.png", "-o", "whole"]) == 0
    monkeypatch.setattr(FramesFolder, "add", interrupted)
    assert main([*run, "--start", "one.png", "-o", "parts"]) == 130
    monkeypatch.setattr(FramesFolder, "add", add)
    assert main([*run, "--start", "two.png", "-o", "parts", "--resume"]) == 2
    assert "--start" in capsys.readouterr().err
    assert main([*run, "--start", "one.png", "-o", "parts", "--resume"]) == 0
    assert torch.equal(frames("whole"), frames("parts"))


def test_an_existing_folder_is_replaced_only_when_asked(clip, capsys):
    run = ["synth", "drops", "--preset", "fast", "--frames", "3"]
    assert main(run) == 0
    assert main([*run, "--seed", "1"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    first = frames("drops_synth")
    assert main([*run, "--seed", "1", "--overwrite"]) == 0
    assert not torch.equal(frames("drops_synth"), first)


@pytest.mark.parametrize(
    "arguments",
    [["--frames", "0"], ["--frames", "1" + 400 * "0"], ["--frames", "9", "--seconds", "1"], ["--stay", "-1"]],
)
def test_options_that_are_none_are_refused(clip, arguments):
    with pytest.raises(SystemExit) as error:
        main(["synth", "drops", *arguments])
    assert error.value.code == 2
