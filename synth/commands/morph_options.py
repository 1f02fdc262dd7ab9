"""What single methods of `kwatra morph` are told: patterns, patches and texton masks, as arguments and as options."""

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import synth
from synth import io
from synth.commands.parsing import file, positive, whole

if TYPE_CHECKING:
    from torch import Tensor

_METHODS = {
    "patterns": ("patterns", "landmarks", "threshold", "scale_elements", "median"),
    "patches": ("feature_weight", "map_weight", "independent"),
    "textons": ("masks", "colors", "tolerance", "published", "window_a", "window_b"),
}
_FILES = ("patterns", "landmarks", "masks")


def add_method_options(parser: argparse.ArgumentParser) -> None:
    """Add a group of arguments for each method that has some."""
    add = parser.add_argument_group("--method patterns: elements of A become elements of B").add_argument
    either = parser.add_mutually_exclusive_group()
    either.add_argument("--patterns", type=file, nargs=2, metavar=("A_JSON", "B_JSON"), help="files of kwatra "
        "patterns; where one has landmarks only, patterns are detected (default: elements that are found)")  # fmt: skip
    either.add_argument("--landmarks", type=file, metavar="FILE", help="a file with the landmarks of one pattern of A "
        "and one of B, in the order in which they are to become each other; the others are detected")  # fmt: skip
    add("--threshold", type=positive, metavar="T", help="how far from the landmarks' pattern others may be")
    add("--scale-elements", type=positive, metavar="S", help="scale elements by this, up to 1, while they move "
        "(default: as keeps them apart)")  # fmt: skip
    add("--median", type=whole(1), metavar="N", help="median over N frames, an odd number (default: 1, none)")
    add = parser.add_argument_group("--method patches: patches of A turned into patches of B").add_argument
    add("--feature-weight", type=positive, metavar="X", help="what lying by features like those there counts beside "
        "all colors together (default: 1)")  # fmt: skip
    add("--map-weight", type=positive, metavar="X", help="with --map or --weights: more keeps them exactly, less lets "
        "textures decide (default: 2)")  # fmt: skip
    add("--independent", action="store_const", const=True, help="every frame by itself, as Ruiters, Schnabel and Klein")
    add("--show-features", type=file, nargs="+", metavar="OUT", help="write where each texture's features are, to look "
        "at, or to edit and give back with --features")  # fmt: skip
    add = parser.add_argument_group("--method textons: texture of A and of B under one mask").add_argument
    either = parser.add_mutually_exclusive_group()
    either.add_argument("--masks", type=file, nargs=2, metavar=("A_MASK", "B_MASK"), help="images, white in elements")
    either.add_argument("--colors", type=color, nargs=4, metavar=("FG_A", "BG_A", "FG_B", "BG_B"), help="foreground "
        "and background of A and of B as R,G,B from 0 to 255 (default: elements are found)")  # fmt: skip
    add("--tolerance", type=positive, metavar="X", help="with --colors: count as foreground what is nearer to the "
        "background by up to X, where black to white is 1.73")  # fmt: skip
    add("--show-masks", type=file, nargs=2, metavar=("A_OUT", "B_OUT"), help="write the masks that are used, to look "
        "at, or to edit and give back")  # fmt: skip
    add("--published", action="store_const", const=True, help="pixel by pixel as Tonietto and Walter; takes minutes")
    add("--window-a", type=whole(3), metavar="PX", help="its windows' width in A, odd (default: 11)")
    add("--window-b", type=whole(3), metavar="PX", help="its windows' width in B, odd (default: 17)")


def method_options(arguments: argparse.Namespace, method: str, pictures: "Sequence[Tensor]") -> dict[str, Any]:
    """The options that were given, by name, as the method takes them for the pictures A and B.

    Raises InputError for options of another method, and for files that cannot be used.
    """
    given = {name: value for names in _METHODS.values() for name in names
             if (value := getattr(arguments, name)) is not None}  # fmt: skip
    for name in given:
        owner = next(owner for owner, names in _METHODS.items() if name in names)
        if owner != method:
            raise synth.InputError(f"--{name.replace('_', '-')} belongs to --method {owner}; the method is {method}")
    if "tolerance" in given and "colors" not in given:
        raise synth.InputError("--tolerance says how colors are told apart; give --colors too, or leave it out")
    if "threshold" in given and "patterns" not in given and "landmarks" not in given:
        raise synth.InputError("--threshold says what is like given landmarks; give --landmarks too, or leave it out")
    for name in ("window_a", "window_b"):
        if name in given and "published" not in given:
            raise synth.InputError(
                f"--{name.replace('_', '-')} is for frames made pixel by pixel; give --published too, or leave it out"
            )
    options = {name: value for name, value in given.items() if name not in (*_FILES, "colors")}
    for name in _FILES:
        if name in given:
            options |= _read(name, given[name], pictures)
    if "colors" in given:
        a, on_a, b, on_b = given["colors"]
        options |= {"colors_a": (a, on_a), "colors_b": (b, on_b)}
    return options


def color(text: str) -> tuple[float, ...]:
    """R,G,B, or one gray, from 0 to 255, as values in [0, 1]."""
    parts = text.split(",")
    if len(parts) not in (1, 3) or not all(part.isdecimal() and int(part) <= 255 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is no color; write R,G,B from 0 to 255, as 200,30,30, or one gray")
    return tuple(int(part) / 255 for part in parts)


def _read(name: str, given: Any, pictures: "Sequence[Tensor]") -> dict[str, Any]:
    if name == "masks":
        return {"mask_a": io.read_mask(given[0]).numpy(), "mask_b": io.read_mask(given[1]).numpy()}
    from synth.metamorphosis.patterns import read_landmarks, read_patterns

    if name == "patterns":
        a, b = (read_patterns(path) for path in given)
    else:
        sizes = [(picture.shape[1], picture.shape[2]) for picture in pictures]
        a, b = read_landmarks(given, (sizes[0], sizes[1]))
    return {"patterns_a": a, "patterns_b": b}


def in_order(count: int, there_and_back: bool) -> list[int]:
    """The numbers of so many frames as they are shown: to the last and, if so asked, back to the second."""
    return [*range(count), *(range(count - 2, 0, -1) if there_and_back else ())]
