"""`kwatra fill VIDEO`."""

from pathlib import Path

import numpy as np
import pytest
import torch

import synth
from synth.cli import main
from synth.io.videos import read_video, write_video

GRAY = synth.Kind("uint8", ("Y",))


@pytest.fixture
def drops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> torch.Tensor:
    """8 frames of 24x20 in which blobs drift, as the folder `drops`; the mask of a disc as disc.png."""
    monkeypatch.chdir(tmp_path)
    field = torch.rand(3, 20, 24, generator=torch.Generator().manual_seed(2))
    smooth = torch.nn.functional.avg_pool2d(field.repeat(1, 3, 3), 5, 1, 2)[:, 20:40, 24:48]
    write_video("drops", torch.stack([smooth.roll(t, 1) for t in range(8)], 1), 25.0)
    disc = torch.zeros(1, 20, 24)
    disc[:, 6:12, 8:15] = 1
    synth.write_image("disc.png", disc, GRAY)
    return read_video("drops").frames


def test_a_hole_in_a_single_frame(drops):
    write_video("one", drops[:, :1], 25.0)
    assert main(["fill", "one", "--hole", "disc.png", "-o", "out", "--preset", "fast"]) == 0
    made, hole = read_video("out").frames[:, 0], torch.zeros(20, 24, dtype=torch.bool)
    hole[6:12, 8:15] = True
    assert torch.equal(made[:, ~hole], drops[:, 0, ~hole])
    assert not torch.equal(made, drops[:, 0])


def test_a_folder_is_that_of_the_frames_whether_it_exists_or_not(drops):
    Path("there").mkdir()
    for out in ("there/", "new/"):
        run = ["fill", "drops", "--hole", "disc.png", "-o", out, "--preset", "fast", "--overwrite"]
        assert main(run) == 0
        assert read_video(out).frames.shape == drops.shape


def test_a_file_shows_floats_from_the_least_to_the_largest(drops):
    write_video("bright", 8 * drops[:, :1], 25.0, synth.Kind("float32", ("R", "G", "B")))
    assert main(["fill", "bright", "--hole", "disc.png", "-o", "out.mov", "--preset", "fast"]) == 0
    made, own = read_video("out.mov").frames[:, 0], drops[:, 0]
    wanted = (own - own.min()) / (own.max() - own.min())
    assert float((made - wanted)[:, 14:].abs().mean()) < 0.03


def test_a_hole_in_every_frame_and_one_in_space_and_time(drops):
    masks = torch.zeros(1, 8, 20, 24)
    masks[:, 3:5, 4:16, 6:18] = 1
    write_video("masks", masks, 25.0, GRAY)
    for mask, out in (("disc.png", "a"), ("masks", "b")):
        run = ["fill", "drops", "--hole", mask, "-o", out, "--preset", "fast", "--map", f"{out}.npy"]
        assert main(run) == 0
        hole = masks[0] > 0 if mask == "masks" else torch.zeros(8, 20, 24, dtype=torch.bool)
        if mask == "disc.png":
            hole[:, 6:12, 8:15] = True
        made = read_video(out).frames
        assert torch.equal(made[:, ~hole], drops[:, ~hole])
        where = np.load(f"{out}.npy")
        assert not hole.numpy()[tuple(where[1:])].any()  # nothing is copied from the hole
        assert not torch.equal(made, drops)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "say with --hole what is to be filled"),
        (["--hole", "disc.png", "--extend", "4"], "--extend is for images"),
        (["--hole", "short"], "short is 3 frames of 24x20"),
        (["--hole", "small.png"], "small.png is 9x8 but drops 8 frames of 24x20"),
        (["--hole", "black.png"], "black.png is black everywhere"),
        (["--hole", "disc.png", "--exemplar", "disc.png"], "fill it from videos"),
        (["--hole", "disc.png"], "--overwrite"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(drops, arguments, said, capsys):
    write_video("short", torch.zeros(1, 3, 20, 24), 25.0, GRAY)
    write_video("drops_fill", drops, 25.0)
    synth.write_image("black.png", torch.zeros(1, 20, 24), GRAY)
    synth.write_image("small.png", torch.ones(1, 8, 9), GRAY)
    elsewhere = [] if said == "--overwrite" else ["-o", "new"]
    assert main(["fill", "drops", *arguments, *elsewhere]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
