"""`kwatra fill` and `kwatra synth --guide`: what they write, and what they refuse."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from synth import Kind, read_image, write_image
from synth.cli import main
from synth.io.images import read_array

GRAY = Kind("uint8", ("Y",))


def picture(channels: int, size: tuple[int, int] = (64, 72)) -> torch.Tensor:
    wave = torch.sin(torch.arange(size[1]) * 0.8) * 0.3 + 0.5
    return (wave + 0.1 * torch.randn(channels, *size, generator=torch.Generator().manual_seed(0))).clamp(0, 1)


def hole(size: tuple[int, int] = (64, 72)) -> torch.Tensor:
    mask = torch.zeros(1, *size)
    mask[:, 20:40, 30:50] = 1
    return mask


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder with wall.png, its hole, and label maps."""
    monkeypatch.chdir(tmp_path)
    write_image("wall.png", picture(3), Kind("uint8", ("R", "G", "B")))
    write_image("hole.png", hole(), GRAY)
    write_image("small.png", hole((50, 50)), GRAY)
    write_image("none.png", 0 * hole(), GRAY)
    write_image("all.png", 0 * hole() + 1, GRAY)
    return tmp_path


@pytest.mark.parametrize(
    ("suffix", "kind"),
    [(".png", Kind("uint16", ("R", "G", "B", "A"))), (".tif", Kind("float32", ("Y", "X1"))), (".png", GRAY)],
)
def test_known_pixels_come_back_as_the_file_holds_them(folder: Path, suffix: str, kind: Kind) -> None:
    write_image(f"in{suffix}", picture(len(kind.channels)), kind)
    assert main(["fill", f"in{suffix}", "--hole", "hole.png", "--preset", "fast"]) == 0
    before, after = read_array(f"in{suffix}")[0], read_array(f"in_fill{suffix}")[0]
    known = hole()[0].numpy() == 0
    assert read_array(f"in_fill{suffix}")[1] == kind
    assert np.array_equal(before[known], after[known])
    assert not np.array_equal(before[~known], after[~known])


@pytest.mark.parametrize(
    "command", ["synth in.png", "fill in.png --hole hole.png", "animate in.png --flow sink --size 40x32 -o out"]
)
def test_colors_that_cannot_be_seen_color_nothing(folder: Path, command: str) -> None:
    noise = torch.rand(1, 4, 16, 18, generator=torch.Generator().manual_seed(0))
    smooth = torch.nn.functional.interpolate(noise, (64, 72), mode="bicubic")[0].clamp(0, 1)
    clear = smooth[3] < 0.5
    pixels = torch.cat([torch.where(clear, 1.0, 0.2 * smooth[:3] + 0.1), (~clear).float()[None]])
    write_image("in.png", pixels, Kind("uint8", ("R", "G", "B", "A")))
    options = ["--preset", "fast", *(["--frames", "3"] if "animate" in command else [])]
    assert main([*command.split(), *options]) == 0
    name = command.split()[0]
    made = read_image("out/000002.png" if name == "animate" else f"in_{name}.png").pixels
    made = made[:, 20:40, 30:50] if name == "fill" else made
    assert float(made[:3, made[3] > 0.25].max()) < 0.4


def test_it_says_what_it_did_and_takes_exemplars(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flat = torch.full((3, 40, 40), 0.2)
    write_image("flat.png", flat, Kind("uint8", ("R", "G", "B")))
    options = ["--exemplar", "flat.png", "--exemplar", "flat.png", "-o", "out.png", "--preset", "fast"]
    assert main(["fill", "wall.png", "--hole", "hole.png", *options]) == 0
    assert capsys.readouterr().out.startswith("wrote out.png: 72x64, 400 pixels filled, seed 0, in ")
    middle = read_image("out.png").pixels[:, 26:34, 36:44]
    assert float((middle - 0.2).abs().max()) < 0.1  # what differs at the border is spread over the inside


def test_bad_holes_are_refused(folder: Path, refused: Callable[..., str]) -> None:
    write_image("gray.png", picture(1), GRAY)
    assert "small.png is 50x50 but wall.png 72x64" in refused("fill", "wall.png", "--hole", "small.png")
    assert "none.png is black everywhere" in refused("fill", "wall.png", "--hole", "none.png")
    assert "covers the whole image" in refused("fill", "wall.png", "--hole", "all.png")
    assert "does not exist" in refused("fill", "wall.png", "--hole", "lost.png")
    message = refused("fill", "wall.png", "--hole", "hole.png", "--exemplar", "gray.png")
    assert "gray.png holds uint8 Y but wall.png holds uint8 RGB" in message
    assert "exists" in refused("fill", "wall.png", "--hole", "hole.png", "-o", "gray.png")
    assert "--hole" in refused("fill", "wall.png")


def test_a_guide_gives_the_size_and_the_place(folder: Path) -> None:
    image = torch.cat([torch.full((3, 64, 32), 0.2), torch.full((3, 64, 32), 0.8)], 2)
    write_image("two.png", image, Kind("uint8", ("R", "G", "B")))
    write_image("labels.png", (image[:1] > 0.5).float(), GRAY)
    left = (torch.arange(72) < 36).float().expand(1, 64, 72)
    write_image("wanted.png", left, GRAY)
    assert main(["synth", "two.png", "--guide", "labels.png=wanted.png", "--preset", "fast"]) == 0
    made = read_image("two_synth.png").pixels
    assert made.shape == (3, 64, 72)
    assert float(((made[0] > 0.5) != (left[0] > 0.5)).float().mean()) < 0.03


def test_bad_guides_are_refused(folder: Path, refused: Callable[..., str]) -> None:
    assert "write EXEMPLAR_MAP=OUTPUT_MAP" in refused("synth", "wall.png", "--guide", "hole.png")
    assert "a guide's map is 50x50" in refused("synth", "wall.png", "--guide", "small.png=hole.png")
    message = refused("synth", "wall.png", "--guide", "hole.png=small.png", "--size", "60x50")
    assert "the guide's output map is 50x50 but the output 60x50" in message
    assert "holds uint8 RGB" in refused("synth", "wall.png", "--guide", "wall.png=hole.png")
    assert "names 1 map for 2 exemplars" in refused("synth", "wall.png", "wall.png", "--guide", "hole.png=hole.png")
    assert "no number above 0" in refused("synth", "wall.png", "--guide", "a=b", "--guide-weight", "0")
