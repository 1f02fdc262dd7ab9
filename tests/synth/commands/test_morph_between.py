"""`kwatra morph` of several textures and with maps: what it writes, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.metamorphosis.patches.interpolation import Interpolation

COLOR, GRAY = Kind("uint8", ("R", "G", "B")), Kind("uint8", ("Y",))
SIZE = 32


def dots(seed: int, tone: tuple[float, float, float]) -> Tensor:
    """Colored noise of blobs, (3, SIZE, SIZE)."""
    noise = torch.rand(1, 1, SIZE + 4, SIZE + 4, generator=torch.Generator().manual_seed(seed))
    blobs = torch.nn.functional.avg_pool2d(noise, 5, 1)[0]
    return ((blobs - 0.3) * 2).clamp(0, 1) * torch.tensor(tone).view(3, 1, 1)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: a.png, b.png and c.png of one kind, gray.png, a map and weights."""
    monkeypatch.chdir(tmp_path)
    for name, seed, tone in (("a", 0, (1.0, 0.5, 0.3)), ("b", 1, (0.2, 0.5, 1.0)), ("c", 2, (0.2, 1.0, 0.3))):
        write_image(f"{name}.png", dots(seed, tone), COLOR)
    write_image("gray.png", dots(3, (1.0, 1.0, 1.0))[:1], GRAY)
    ramp = torch.tensor([0.0] * 16 + [1.0] * 16).expand(1, SIZE, -1)
    write_image("map.png", ramp, GRAY)
    write_image("weights.png", torch.cat([1 - ramp, ramp, 0 * ramp]), COLOR)
    for number in range(3):
        Path("maps").mkdir(exist_ok=True)
        write_image(f"maps/{number:06d}.png", torch.full((1, SIZE, SIZE), float(number > 0)), GRAY)
    return tmp_path


def colors(path: str) -> Tensor:
    return read_image(path).pixels.flatten(1).mean(1)


def test_a_gray_texture_among_colored_ones_is_colored(folder: Path) -> None:
    assert main(["morph", "a.png", "b.png", "gray.png", "--at", "0,0,1", "--preset", "fast"]) == 0
    assert float((colors("a_b_gray.png") - colors("gray.png")).abs().max()) < 0.05


def test_three_textures_at_weights(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["morph", "a.png", "b.png", "c.png", "--at", "1,1,2", "--preset", "fast"]
    assert main([*words, "--show-features", "1.png", "2.png", "3.png"]) == 0
    expected = torch.stack([colors("a.png"), colors("b.png"), 2 * colors("c.png")]).sum(0) / 4
    assert float((colors("a_b_c.png") - expected).abs().max()) < 0.05
    assert set(read_image("2.png").pixels.unique().tolist()) == {0.0, 1.0}
    said = capsys.readouterr().out
    assert said.startswith(f"wrote a_b_c.png: {SIZE}x{SIZE} in ")
    assert "features are" in said


@pytest.mark.parametrize(
    "words", [["a.png", "b.png", "--map", "map.png"], ["a.png", "b.png", "c.png", "--weights", "weights.png"]]
)
def test_a_map_has_its_size_and_its_ends(folder: Path, words: list[str]) -> None:
    assert main(["morph", *words, "-o", "out.png", "--preset", "fast"]) == 0
    made = read_image("out.png").pixels
    assert made.shape == (3, SIZE, SIZE)
    assert float((made[:, :, :8].flatten(1).mean(1) - colors("a.png")).abs().max()) < 0.12
    assert float((made[:, :, -8:].flatten(1).mean(1) - colors("b.png")).abs().max()) < 0.12


def test_maps_in_time_are_a_film(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["morph", "a.png", "b.png", "--map", "maps", "-o", "film", "--preset", "fast"]) == 0
    frames = [read_image(path).pixels for path in sorted(Path("film").iterdir())]
    assert len(frames) == 3
    assert torch.equal(frames[1], frames[2])
    assert not torch.equal(frames[0], frames[1])
    assert f"3 frames of {SIZE}x{SIZE}" in capsys.readouterr().out


@pytest.mark.parametrize("back", [False, True])
def test_an_interrupt_leaves_the_frames_of_a_map_film_that_are_whole(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], back: bool
) -> None:
    def interrupted(*arguments: object, **named: object) -> None:
        raise KeyboardInterrupt

    write_image("maps/000000.png", torch.ones(1, SIZE, SIZE), GRAY, overwrite=True)
    write_image("maps/000002.png", torch.full((1, SIZE, SIZE), 0.5), GRAY, overwrite=True)
    monkeypatch.setattr(Interpolation, "_settled", interrupted)  # what is not as before, nor one texture alone
    way = ["--there-and-back"] if back else []
    assert main(["morph", "a.png", "b.png", "--map", "maps", "-o", "part", "--preset", "fast", *way]) == 130
    assert f"interrupted with 2 of {4 if back else 3} frames whole in part" in capsys.readouterr().err
    assert sorted(path.name for path in Path("part").iterdir()) == ["000000.png", "000001.png"]


def test_features_of_a_film_from_a_to_b(folder: Path) -> None:
    words = ["morph", "a.png", "b.png", "--at", "0.5", "-o", "half.png", "--preset", "fast"]
    assert main([*words, "--show-features", "fa.png", "fb.png"]) == 0
    assert main([*words, "--features", "fa.png", "fb.png", "--overwrite"]) == 0
    assert read_image("half.png").pixels.shape == (3, SIZE, SIZE)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["a.png", "b.png", "c.png"], "nothing says what lies where"),
        (["a.png", "b.png", "--map", "map.png", "--at", "1,1"], "both --map and --at"),
        (["a.png", "b.png", "c.png", "--at", "1,1"], "give 3"),
        (["a.png", "b.png", "c.png", "--at", "0.5"], "there are 3 textures; give the weight of each (--at 1,1,1)"),
        (["a.png", "b.png", "c.png", "--at", "1,1,-1"], "from 0 on"),
        (["a.png", "b.png", "c.png", "--map", "map.png"], "give --weights, or"),
        (["a.png", "b.png", "c.png", "--weights", "map.png"], "1 channel but there are 3"),
        (["a.png", "b.png", "--map", "map.png", "--method", "control"], "are for patches"),
        (["a.png", "b.png", "--map", "map.png", "--frames", "3"], "--frames is for films"),
        (["a.png", "b.png", "--map", "map.png", "--there-and-back"], "this is one image"),
        (["a.png", "b.png", "--map", "map.png", "-o", "folder"], "cannot hold one image"),
        (["a.png", "b.png", "--map", "map.png", "--features", "map.png"], "1 file for 2"),
        (["a.png", "b.png", "--map", "map.png", "--show-features", "f.png"], "1 file for 2"),
        (["a.png", "b.png", "--features", "map.png"], "1 file; name A's and B's"),
        (["a.png", "b.png", "--method", "control", "--show-features", "1.png", "2.png"], "shows no features"),
        (["a.png", "b.png", "--method", "control", "--independent"], "belongs to --method patches"),
        (["a.png", "b.png", "--map", "none.png"], "none.png"),
    ],
)  # fmt: skip
def test_what_will_not_do_is_said(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    before = sorted(Path().rglob("*"))
    with np.errstate(all="raise"):
        assert main(["morph", *words]) == 2
    assert said in capsys.readouterr().err
    assert sorted(Path().rglob("*")) == before


def test_one_texture_lacks_the_other_only(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["morph", "a.png"])
    assert "required: B (see" in capsys.readouterr().err
