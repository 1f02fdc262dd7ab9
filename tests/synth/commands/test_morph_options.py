"""What single methods of `kwatra morph` are told."""

import argparse
import json
from pathlib import Path

import numpy as np
import pytest
import torch

from kwatra import InputError
from synth import Kind, write_image
from synth.commands.morph_options import add_method_options, method_options
from synth.metamorphosis.patterns import PatternMorph
from synth.metamorphosis.textons import TextonMorph


def options(method: str, *words: str) -> dict[str, object]:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_method_options(parser)
    return method_options(parser.parse_args(words), method)


def test_nothing_given_is_no_option() -> None:
    assert options("patterns") == options("textons") == options("blend") == {}


def test_patterns_are_read(tmp_path: Path) -> None:
    content = {"format": "kwatra patterns", "version": 1, "width": 64, "height": 48}
    for name, x in (("a", 5), ("b", 9)):
        landmarks = [[x, 5], [20, 5], [20, 15]]
        (tmp_path / f"{name}.json").write_text(json.dumps(content | {"landmarks": landmarks}))
    files = str(tmp_path / "a.json"), str(tmp_path / "b.json")
    made = PatternMorph(**options("patterns", "--patterns", *files, "--median", "3", "--scale-elements", ".5"))
    assert made.patterns_a.landmarks[0, 0] == 5
    assert made.patterns_b.landmarks[0, 0] == 9
    assert (made.median, made.scale_elements) == (3, 0.5)


def test_masks_colors_and_windows_are_read(tmp_path: Path) -> None:
    mask = torch.zeros(1, 8, 9)
    mask[:, 2:5, 3:6] = 1
    for name, values in (("a", mask), ("b", 1 - mask)):
        write_image(tmp_path / f"{name}.png", values, Kind("uint8", ("Y",)))
    made = TextonMorph(**options("textons", "--masks", str(tmp_path / "a.png"), str(tmp_path / "b.png"), "--published"))
    assert np.array_equal(made.mask_a, mask[0].bool().numpy())
    assert np.array_equal(made.mask_b, ~made.mask_a)
    assert made.published
    colors = ("--colors", "255,0,0", "255,255,255", "0,0,51", "0,0,0", "--tolerance", ".2", "--window-b", "9")
    made = TextonMorph(**options("textons", *colors))
    assert made.colors_a == ((1, 0, 0), (1, 1, 1))
    assert made.colors_b == ((0, 0, 0.2), (0, 0, 0))
    assert (made.tolerance, made.window_b) == (0.2, 9)


@pytest.mark.parametrize(
    ("method", "words", "match"),
    [
        ("control", ["--median", "3"], "--median belongs to --method patterns; the method is control"),
        ("patterns", ["--window-a", "9"], "--window-a belongs to --method textons"),
        ("textons", ["--tolerance", ".1"], "give --colors too"),
        ("patterns", ["--patterns", "no.json", "no.json"], "no.json does not exist"),
        ("textons", ["--masks", "no.png", "no.png"], "no.png does not exist"),
    ],
)
def test_what_does_not_fit_is_refused(method: str, words: list[str], match: str) -> None:
    with pytest.raises(InputError, match=match):
        options(method, *words)


@pytest.mark.parametrize("text", ["red", "1,2", "256,0,0", "1,2,3,4", "1.5,0,0", ""])
def test_colors_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentError, match="is no color"):
        options("textons", "--colors", text, "0", "0", "0")
