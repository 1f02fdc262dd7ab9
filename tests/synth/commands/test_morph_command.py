"""`kwatra morph`: what it writes, and what it refuses."""

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

import synth
from synth import Kind, read_flow, read_image, write_image
from synth.cli import main
from synth.commands.morph_folder import Folder
from synth.io.videos import read_video

COLOR, GRAY = Kind("uint8", ("R", "G", "B")), Kind("uint8", ("Y",))


def stripes(angle: float, count: int, size: tuple[int, int] = (32, 40)) -> torch.Tensor:
    y, x = torch.meshgrid(torch.arange(size[0]) / 32, torch.arange(size[1]) / 32, indexing="ij")
    return (0.5 + 0.4 * torch.sin(2 * np.pi * count * (x * np.cos(angle) + y * np.sin(angle))))[None]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: a.png in color, b.png, gray.png, deep.png of 16 bits, marks for a and b, and tiny.png."""
    monkeypatch.chdir(tmp_path)
    write_image("a.png", stripes(0.2, 4).expand(3, -1, -1), COLOR)
    write_image("b.png", stripes(0.4, 5) * torch.tensor([1.0, 0.6, 0.3]).view(3, 1, 1), COLOR)
    write_image("gray.png", stripes(1.2, 4), GRAY)
    write_image("deep.png", stripes(1.2, 3), Kind("uint16", ("Y",)))
    write_image("float.tif", stripes(1.2, 3) * 10, Kind("float32", ("Y",)))
    write_image("many.tif", stripes(1.2, 3).expand(5, -1, -1), Kind("uint8", tuple("abcde")))
    write_image("marks.png", (stripes(0.2, 4) > 0.6).float(), GRAY)
    write_image("small_marks.png", (stripes(0.2, 4, (20, 20)) > 0.6).float(), GRAY)
    write_image("tiny.png", stripes(0.2, 4, (8, 8)).expand(3, -1, -1), COLOR)
    return tmp_path


def test_by_default_all_frames_are_in_one_picture(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["morph", "a.png", "b.png", "--method", "blend"]) == 0
    sheet = read_image("a_b.png").pixels
    assert sheet.shape == (3, 2 * 32 + 4, 6 * 40 + 5 * 4)
    assert torch.equal(sheet[:, :32, :40], read_image("a.png").pixels)
    assert torch.equal(sheet[:, 36:, 176:216], read_image("b.png").pixels)
    assert bool((sheet[:, 32:36] == 1).all())
    assert capsys.readouterr().out.startswith("wrote a_b.png: 11 frames of 40x32 in ")


def test_a_folder_of_frames_the_energy_and_the_flow(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["morph", "a.png", "b.png", "-o", "film", "--frames", "4", "--method", "control", "--preset", "fast"]
    words += ["--features", "marks.png", "marks.png", "--energy", "energy.csv", "--flow", "way.npz"]
    assert main(words) == 0
    assert sorted(path.name for path in Path("film").iterdir()) == [f"{n:06d}.png" for n in range(4)]
    assert torch.equal(read_image("film/000000.png").pixels, read_image("a.png").pixels)
    assert torch.equal(read_image("film/000003.png").pixels, read_image("b.png").pixels)
    rows = list(csv.DictReader(Path("energy.csv").read_text().splitlines()))
    assert {"level", "factor", "iteration", "velocity", "change", "features", "total"} == set(rows[0])
    velocity = read_flow("way.npz").flow
    a, b = (read_image(name).pixels for name in ("a.png", "b.png"))
    made = synth.morph(a, b, 4, method="control", preset="fast", features=(mask(), mask()))
    expected = made.film.velocity
    torch.testing.assert_close(velocity, expected)
    assert main(["flow", "way.npz", "--picture", "way.png"]) == 0
    assert read_image("way.png").pixels.shape == (3, 32, 40)
    assert "no map folds" in capsys.readouterr().out


def mask() -> torch.Tensor:
    return read_image("marks.png").pixels[0] > 0.5


def test_the_energy_is_drawn(folder: Path) -> None:
    words = ["morph", "a.png", "b.png", "-o", "x.png", "--at", "0.5", "--method", "control", "--preset", "fast"]
    assert main([*words, "--energy", "e.png"]) == 0
    assert read_image("e.png").pixels.shape == (3, 480, 960)


def test_one_frame_at_a_time(folder: Path) -> None:
    assert main(["morph", "a.png", "b.png", "-o", "half.png", "--at", "0.5", "--method", "blend"]) == 0
    middle = (read_image("a.png").pixels + read_image("b.png").pixels) / 2
    torch.testing.assert_close(read_image("half.png").pixels, middle, atol=0.0021, rtol=0)


def test_there_and_back_in_a_loop(folder: Path) -> None:
    words = ["morph", "a.png", "b.png", "--method", "blend", "--frames", "5", "--there-and-back"]
    assert main([*words, "-o", "film.gif", "--fps", "10"]) == 0
    assert main([*words, "-o", "film.mp4"]) == 0
    assert main([*words, "-o", "film.mov"]) == 0
    assert read_video("film.mov").frames.shape == (3, 8, 32, 40)
    assert main([*words, "-o", "frames"]) == 0
    assert read_video("film.gif").frames.shape == (3, 8, 32, 40)
    assert read_video("film.mp4").frames.shape == (3, 8, 32, 40)
    assert torch.equal(read_image("frames/000001.png").pixels, read_image("frames/000007.png").pixels)


def test_gray_and_16_bits_beside_color_of_8(folder: Path) -> None:
    assert main(["morph", "a.png", "deep.png", "-o", "film", "--method", "blend", "--frames", "2"]) == 0
    last = read_image("film/000001.png")
    assert last.kind == Kind("uint16", ("R", "G", "B"))
    assert torch.equal(last.pixels, read_image("deep.png").pixels.expand(3, -1, -1))


def test_what_has_one_bit_is_raised_to_8(folder: Path) -> None:
    write_image("bits.png", (stripes(0.2, 4) > 0.5).float(), Kind("bool", ("Y",)))
    assert main(["morph", "bits.png", "gray.png", "-o", "film", "--method", "blend", "--frames", "2"]) == 0
    last = read_image("film/000001.png")
    assert last.kind == GRAY
    assert torch.equal(last.pixels, read_image("gray.png").pixels)


def test_floats_keep_their_values(folder: Path) -> None:
    write_image("g.tif", stripes(0.1, 3) * 4, Kind("float32", ("Y",)))
    assert main(["morph", "float.tif", "g.tif", "-o", "film", "--method", "blend", "--frames", "2"]) == 0
    torch.testing.assert_close(read_image("film/000000.tif").pixels, read_image("float.tif").pixels, atol=1e-5, rtol=0)
    assert main(["morph", "float.tif", "g.tif", "-o", "film.gif", "--method", "blend"]) == 0


def test_another_size_made_texture_again(folder: Path) -> None:
    words = [
        "morph",
        "a.png",
        "b.png",
        "-o",
        "wide.png",
        "--at",
        "0.4",
        "--size",
        "64x48",
        "--retexture",
        "--seed",
        "3",
    ]
    assert main([*words, "--preset", "fast"]) == 0
    assert read_image("wide.png").pixels.shape == (3, 48, 64)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["a.png", "none.png"], "none.png does not exist"),
        (["a.png", "b.png", "--method", "magic"], "the method is 'magic'; allowed are control, registration, blend"),
        (["a.png", "b.png", "--frames", "1"], "the number of frames is 1; give at least 2"),
        (["a.png", "b.png", "--at", "1.5"], "'1.5' is no time from 0"),
        (["a.png", "b.png", "--at", "0.5", "--frames", "3"], "not allowed with"),
        (["a.png", "b.png", "--at", "0.5", "-o", "x.mp4"], "--at makes one frame"),
        (["a.png", "b.png", "--at", "0.5", "--there-and-back"], "--at makes one frame"),
        (["a.png", "b.png", "--at", "0.5", "--method", "patterns", "--median", "3"], "--median is over several frames"),
        (["a.png", "b.png", "--method", "blend", "--flow", "v.npz"], "'blend' has no flow; those that do are control"),
        (["a.png", "b.png", "--method", "blend", "--energy", "e.csv"], "'blend' has no energy; those that do are"),
        (["a.png", "b.png", "--method", "blend", "--features", "marks.png", "marks.png"], "takes no features"),
        (["a.png", "b.png", "--features", "marks.png", "small_marks.png"], "B's features have shape .1, 20, 20."),
        (["a.png", "b.png", "--show-masks", "m.png", "n.png"], "'patches' has no masks; those that do are textons"),
        (
            ["a.png", "b.png", "--method", "control", "--flow", "v.flo"],
            "cannot hold a flow in time; end it with .npz or .npy",
        ),
        (["a.png", "b.png", "-o", "a.png"], "a.png exists"),
        (["a.png", "b.png", "-o", "x.png", "--method", "control", "--energy", "x.png"], "x.png would be written twice"),
        (["a.png", "tiny.png"], "A and B have 8x8 px in common; give textures of at least 17x17"),
        (["gray.png", "many.tif"], "save both with the same channels"),
        (["a.png", "b.png", "--size", "70000x20"], "is too large"),
        (["a.png", "b.png", "-o", "x.xyz"], "has an ending that cannot hold"),
    ],
)
def test_what_cannot_be_is_refused(refused: Callable[..., str], arguments: list[str], sentence: str) -> None:
    assert re.search(sentence, refused("morph", *arguments))


def test_masks_are_shown_and_taken_back(folder: Path) -> None:
    y, x = torch.meshgrid(torch.arange(48.0), torch.arange(48.0), indexing="ij")
    discs = ((x % 16 - 8).square() + (y % 16 - 8).square()) < 20
    write_image("discs.png", torch.where(discs, 0.8, 0.3)[None], GRAY)
    write_image("moved.png", torch.where(discs.roll(2, 1), 0.2, 0.6)[None], GRAY)
    words = ["morph", "discs.png", "moved.png", "--method", "textons", "-o", "half.png", "--at", "0.5"]
    colors = ["--colors", "204", "77", "51", "153", "--show-masks", "a_mask.png", "b_mask.png"]
    assert main([*words, *colors]) == 0
    assert torch.equal(read_image("a_mask.png").pixels[0] == 1, discs)
    assert torch.equal(read_image("b_mask.png").pixels[0] == 1, discs.roll(2, 1))
    assert main([*words, "--overwrite", "--masks", "a_mask.png", "b_mask.png"]) == 0


@pytest.mark.parametrize("back", [False, True])
def test_an_interrupt_leaves_the_frames_that_are_whole(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], back: bool
) -> None:
    from synth.metamorphosis.optimal_control import film

    real = film._frame

    def interrupted(*arguments: Any) -> Tensor:
        if arguments[3] > 0.5:
            raise KeyboardInterrupt
        return real(*arguments)

    words = ["morph", "a.png", "b.png", "-o", "film", "--preset", "fast", "--frames", "5", "--method", "control"]
    assert main(words) == 0
    monkeypatch.setattr(film, "_frame", interrupted)
    way = ["--there-and-back"] if back else []
    assert main([*words[:3], "-o", "part", *words[5:], *way]) == 130
    assert f"interrupted with 3 of {8 if back else 5} frames whole in part" in capsys.readouterr().err
    names = ["000000.png", "000001.png", "000002.png"]
    assert sorted(path.name for path in Path("part").iterdir()) == names
    for name in names:
        assert torch.equal(read_image(f"part/{name}").pixels, read_image(f"film/{name}").pixels)


def test_an_interrupt_leaves_nothing_half_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from synth.metamorphosis.optimal_control import film

    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(film, "_frame", interrupted)
    before = set(folder.rglob("*"))
    for output in ("film.mp4", "film"):
        assert main(["morph", "a.png", "b.png", "-o", output, "--method", "control", "--preset", "fast"]) == 130
    assert set(folder.rglob("*")) == before


def test_an_interrupt_before_the_first_frame_leaves_nothing_and_after_it_what_is_whole(tmp_path: Path) -> None:
    def interrupted(target: Path) -> None:
        for number in range(count):
            target.mkdir(exist_ok=True)
            (target / f"{number}.png").touch()
        raise KeyboardInterrupt

    count, folder = 0, Folder(tmp_path / "film", 5)
    with pytest.raises(KeyboardInterrupt):
        folder.keeping(interrupted)(tmp_path / "none")
    count = 2
    folder.keeping(interrupted)(tmp_path / "some")
    with pytest.raises(KeyboardInterrupt, match="interrupted with 2 of 5 frames whole"):
        folder.tell()
    Folder(tmp_path, 5).tell()
