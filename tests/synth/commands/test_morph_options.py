"""What single methods of `kwatra morph` are told."""

import argparse
import json
from pathlib import Path

import numpy as np
import pytest
import torch

from kwatra import InputError
from synth import Kind, write_image
from synth.commands.morph_options import add_method_options, in_order, method_options
from synth.metamorphosis.patterns import PatternMorph
from synth.metamorphosis.textons import TextonMorph

PICTURE = torch.zeros(3, 48, 64)


LANDMARKS = {
    "format": "kwatra landmarks",
    "version": 1,
    "a": [[5, 5], [20, 5], [20, 15]],
    "b": [[9, 5], [3, 5], [2, 1]],
}


def options(method: str, *words: str) -> dict[str, object]:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_method_options(parser)
    return method_options(parser.parse_args(words), method, (PICTURE, PICTURE))


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


def test_landmarks_of_both_are_read_from_one_file(tmp_path: Path) -> None:
    (tmp_path / "both.json").write_text(json.dumps(LANDMARKS))
    made = PatternMorph(**options("patterns", "--landmarks", str(tmp_path / "both.json"), "--threshold", "0.7"))
    assert made.patterns_a.landmarks.tolist() == LANDMARKS["a"]
    assert made.patterns_b.landmarks.tolist() == LANDMARKS["b"]
    assert made.patterns_a.found is made.patterns_b.found is None
    assert made.patterns_b.size == (48, 64)
    assert made.threshold == 0.7


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"b": [[9, 5], [3, 5], [2, 1], [0, 0]]}, "both.json: it has 3 landmarks in A and 4 in B; give equally many"),
        ({"a": [[5, 5], [20, 5]]}, "has 2 landmarks; give at least 3"),
        ({"a": [[5, 5], [70, 5], [9, 9]]}, r"a landmark at \(70, 5\), outside of the 64x48 image"),
        ({"version": 2}, "its version is 2; this program reads version 1"),
        ({"c": 1}, "unknown keys 'c'"),
        ({"format": "kwatra patterns"}, "it is no file of landmarks"),
    ],
)
def test_landmarks_that_cannot_be_are_refused(tmp_path: Path, change: dict[str, object], match: str) -> None:
    (tmp_path / "both.json").write_text(json.dumps(LANDMARKS | change))
    with pytest.raises(InputError, match=match):
        options("patterns", "--landmarks", str(tmp_path / "both.json"))


def test_masks_colors_and_windows_are_read(tmp_path: Path) -> None:
    mask = torch.zeros(1, 8, 9)
    mask[:, 2:5, 3:6] = 1
    for name, values in (("a", mask), ("b", 1 - mask)):
        write_image(tmp_path / f"{name}.png", values, Kind("uint8", ("Y",)))
    made = TextonMorph(**options("textons", "--masks", str(tmp_path / "a.png"), str(tmp_path / "b.png"), "--published"))
    assert np.array_equal(made.mask_a, mask[0].bool().numpy())
    assert np.array_equal(made.mask_b, ~made.mask_a)
    assert made.published
    colors = (
        "--colors",
        "255,0,0",
        "255,255,255",
        "0,0,51",
        "0,0,0",
        "--tolerance",
        ".2",
        "--published",
        "--window-b",
        "9",
    )
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
        ("patterns", ["--threshold", ".5"], "give --landmarks too"),
        ("textons", ["--window-b", "9"], "--window-b is for frames made pixel by pixel; give --published too"),
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


def test_back_again_neither_end_is_shown_twice() -> None:
    assert in_order(4, False) == [0, 1, 2, 3]
    assert in_order(4, True) == [0, 1, 2, 3, 2, 1]
    assert in_order(2, True) == [0, 1]
    assert in_order(1, True) == [0]
