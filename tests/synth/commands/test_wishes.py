"""What synth is asked of single pixels, and holes that fill finds by itself or makes at the border."""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from synth import Kind, read_image, synthesize, write_image
from synth.cli import main
from synth.commands.guides import guide_weights
from synth.io.images import read_array
from synth.texture import labels, tones
from synth.texture.toning import WEIGHT

GRAY, RGB = Kind("uint8", ("Y",)), Kind("uint8", ("R", "G", "B"))
FAST = ["--preset", "fast"]


def noise(channels: int, height: int = 32, width: int = 40) -> torch.Tensor:
    return torch.rand(channels, height, width, generator=torch.Generator().manual_seed(0)) * 0.5


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: an exemplar whose left half is darker, masks, and a bright picture with a mask of its own."""
    monkeypatch.chdir(tmp_path)
    left = (torch.arange(40) < 20).float().expand(1, 32, 40)
    write_image("a.png", torch.where(left > 0, noise(3) * 0.5, noise(3) + 0.5), RGB)
    write_image("left.png", left, GRAY)
    disc = torch.zeros(1, 48, 48)
    disc[:, 16:32, 16:32] = 1
    write_image("disc.png", disc, GRAY)
    write_image("logo.png", torch.cat([torch.full((3, 48, 48), 1.0), disc]), Kind("uint8", ("R", "G", "B", "A")))
    write_image("dark.png", torch.full((3, 48, 48), 0.1), RGB)
    return tmp_path


def test_only_what_the_mask_allows_is_copied(folder: Path) -> None:
    assert main(["synth", "a.png", "--exemplar-mask", "left.png", "--map", "m.npy", *FAST]) == 0
    assert np.load("m.npy")[2].max() < 20
    assert main(["synth", "a.png", "--exemplar-mask", "not:left.png", "--map", "n.npy", "--overwrite", *FAST]) == 0
    assert np.load("n.npy")[2].min() >= 20
    picture = read_array("a.png")[0]
    made = synthesize(picture, (40, 40), preset="fast", exemplar_mask=np.arange(40)[None].repeat(32, 0) < 20)
    assert made.source[2].max() < 20


def test_kept_pixels_are_there_exactly_though_no_texture_has_them(folder: Path) -> None:
    assert main(["synth", "a.png", "--keep", "logo.png", *FAST]) == 0
    made = read_array("a_synth.png")[0]
    assert made.shape == (48, 48, 3)
    assert np.all(made[16:32, 16:32] == 255)
    assert made[:12].std() > 10
    assert main(["synth", "a.png", "--keep", "dark.png=not:disc.png", "--overwrite", *FAST]) == 0
    made, dark = read_array("a_synth.png")[0], read_array("dark.png")[0]
    outside = read_array("disc.png")[0][..., 0] == 0
    assert np.array_equal(made[outside], dark[outside])


def test_no_texture_where_the_mask_is_black(folder: Path) -> None:
    assert main(["synth", "a.png", "--mask", "disc.png", *FAST]) == 0
    made = read_array("a_synth.png")[0]
    inside = read_array("disc.png")[0][..., 0] > 0
    assert np.ptp(made[~inside]) == 0
    assert made[inside].std() > 10


def test_soft_pixels_draw_the_output_towards_them(folder: Path) -> None:
    options = ["--soft", "dark.png=disc.png", "--soft-weight", "0.5", "-o", "soft.png"]
    assert main(["synth", "a.png", *options, *FAST]) == 0
    made = read_image("soft.png").pixels
    assert float((made[:, 18:30, 18:30] - 0.1).abs().mean()) < 0.12
    assert float(made[:, :12].mean()) > 0.3


def test_a_drawing_says_how_light_and_dark_it_is_to_be(folder: Path) -> None:
    drawing = torch.linspace(0.2, 0.8, 48).expand(4, 48, 48).clone()
    drawing[3] = 0.5  # how clear a drawing is says nothing of its tones
    write_image("drawing.png", drawing, Kind("uint8", ("R", "G", "B", "A")))
    assert main(["synth", "a.png", "--guide", "tones=drawing.png", "--seed", "3", *FAST]) == 0
    exemplar, wanted = read_image("a.png").pixels, read_image("drawing.png").pixels[:3]
    made = synthesize(exemplar, guide=tones(exemplar, wanted), guide_weight=0.3, seed=3, preset="fast")
    assert torch.equal(read_image("a_synth.png").pixels, (made.image * 255).round() / 255)
    light = made.image.mean((0, 1))
    assert float(light[32:].mean() - light[:16].mean()) > 0.2


def test_shades_put_each_exemplar_where_they_are_drawn(folder: Path) -> None:
    write_image("b.png", read_image("a.png").pixels.flip(2), RGB)
    drawing = torch.zeros(2, 48, 48)
    drawing[0, :, 24:], drawing[1] = 1.0, 0.5  # how clear a drawing is says nothing of its shades
    write_image("drawn.png", drawing, Kind("uint8", ("Y", "A")))
    asked = ["synth", "a.png", "b.png", "--guide", "labels=drawn.png", "--seed", "3", *FAST]
    assert main([*asked, "--map", "m.npy", "--energy", "e.png", "-o", "made.png"]) == 0
    exemplars, wanted = [read_image(name).pixels for name in ("a.png", "b.png")], read_image("drawn.png").pixels[:1]
    made = synthesize(exemplars, guide=labels(exemplars, wanted), seed=3, preset="fast")
    assert torch.equal(read_image("made.png").pixels, (made.image * 255).round() / 255)
    number = np.load("m.npy")[0]
    assert not number[:, :18].any()
    assert number[:, 30:].all()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("--guide labels=", "write labels=IMAGE, with a shade for each exemplar"),
        ("--guide labels=disc.png", "the map of labels has 2 shades for 1 exemplar; draw"),
        ("--guide labels=none.png", "none.png does not exist"),
        ("--guide tones=", "write tones=IMAGE, an image as light and dark as is wanted"),
        ("--guide tones=none.png", "none.png does not exist"),
        ("--keep dark.png", "--keep dark.png does not say which pixels; write --keep dark.png=MASK"),
        ("--keep dark.png=left.png", "left.png is 40x32 but dark.png 48x48"),
        ("--keep left.png=left.png", "left.png holds uint8 Y but the exemplar uint8 RGB"),
        ("--keep dark.png=empty.png", "keeps no pixel"),
        ("--mask empty.png", "empty.png is black everywhere; it is white where texture belongs"),
        ("--soft-weight 2", "--soft-weight says what --soft pixels count but there are none"),
        ("--mask disc.png --size 30x30", "--mask is 48x48 but the output 30x30; give both one size"),
        ("--mask disc.png --keep a.png=left.png", "--keep is 40x32 but the output 48x48"),
        ("--mask disc.png --tile nearest", "--tile nearest chooses a size but --mask has one"),
        ("--exemplar-mask disc.png", "disc.png is 48x48 but its exemplar 40x32"),
        ("--exemplar-mask left.png,left.png", "left.png,left.png does not exist"),
        ("--mask not:none.png", "none.png does not exist"),
    ],
)
def test_bad_wishes_are_refused(folder: Path, refused: Callable[..., str], arguments: str, sentence: str) -> None:
    write_image("empty.png", torch.zeros(1, 48, 48), GRAY)
    assert sentence in refused("synth", "a.png", *FAST, *arguments.split())


def test_what_is_transparent_is_the_hole(folder: Path) -> None:
    kind = Kind("uint8", ("R", "G", "B", "A"))
    alpha = 1 - read_image("disc.png").pixels[:, :32, :40]
    write_image("cut.png", torch.cat([noise(3) + 0.25, alpha]), kind)
    assert main(["fill", "cut.png", *FAST]) == 0
    before, after = read_array("cut.png")[0], read_array("cut_fill.png")[0]
    known = before[..., 3] > 0
    assert np.array_equal(before[known], after[known])
    assert after[..., 3].min() == 255
    assert after[~known][:, :3].std() > 10


def test_an_image_is_extended(folder: Path) -> None:
    assert main(["fill", "a.png", "--extend", "8,0,16,4", *FAST]) == 0
    before, after = read_array("a.png")[0], read_array("a_fill.png")[0]
    assert after.shape == (36, 64, 3)
    assert np.array_equal(after[:32, 8:48], before)
    assert after[:, 50:].std() > 10
    assert main(["fill", "a.png", "--extend", "8", "--hole", "left.png", "-o", "b.png", *FAST]) == 0
    after = read_array("b.png")[0]
    assert after.shape == (48, 56, 3)
    assert np.array_equal(after[8:40, 28:48], before[:, 20:])
    assert not np.array_equal(after[8:40, 8:28], before[:, :20])


def test_nothing_to_fill_and_bad_margins_are_refused(folder: Path, refused: Callable[..., str]) -> None:
    assert "a.png has nothing to fill: give a --hole, --extend it" in refused("fill", "a.png")
    for margins in ("0", "1,2", "-3", "x"):
        assert "are no margins" in refused("fill", "a.png", f"--extend={margins}")
    assert "is too large" in refused("fill", "a.png", "--extend", "70000")


@pytest.mark.parametrize(
    ("guides", "given", "meant"),
    [
        (["a=b"], [], 1.0),
        (["a=b", "c=d"], [2.0], 2.0),
        (["a=b", "c=d"], [2.0, 3.0], [2.0, 3.0]),
        (["tones=d"], [], [WEIGHT]),
        (["a=b", "tones=d"], [], [1.0, WEIGHT]),
        (["a=b", "tones=d"], [2.0], 2.0),
        (["tones=d", "a=b"], [2.0, 3.0], [2.0, 3.0]),
    ],
)
def test_what_guides_count(guides: list[str], given: list[float], meant: float | list[float]) -> None:
    assert guide_weights(argparse.Namespace(guide=guides, guide_weight=given)) == meant
