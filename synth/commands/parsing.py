"""What the arguments of the command line mean; ArgumentTypeError says what they cannot read."""

import argparse
import math
import os
import re
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, NoReturn

MOST_THREADS = 256

_NEGATIVE = re.compile(r"-\.?\d")

Subparsers = Any
"""What argparse's `add_subparsers` returns; its class has no public name."""


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, without the usage; an option is given once."""

    def __init__(self, **named: Any) -> None:
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **named)
        self.register("action", None, _Once)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse, but what follows an option with values is one if a digit follows its minus: a wrong size, say.

        A switch that may be followed by the one word "nearest" takes no other word for its own.
        """
        options = self._option_string_actions
        if args is not None:
            args = _with_negatives(args, [name for name, action in options.items() if action.nargs is None])
        tile = options.get("--tile")
        read, rest = super().parse_known_args(
            _with_values(args) if tile is not None and tile.choices else args, namespace
        )
        if rest:  # argparse itself would refuse it for all commands at once, and so name the help of none
            self.error(f"unrecognized arguments: {' '.join(rest)}")
        return read, rest

    def error(self, message: str) -> NoReturn:
        """End with the one line and exit code 2."""
        self.exit(2, f"kwatra: error: {' '.join(message.split())} (see {self.prog} --help)\n")


class _Once(argparse.Action):
    """Stores what an option is given; given again, it is refused, so that none is forgotten in silence."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        before: set[str] = namespace.__dict__.setdefault("options_given", set())
        if option in before:
            raise argparse.ArgumentError(self, "it is given twice; give it once")
        before.update([option] if option else [])
        setattr(namespace, self.dest, values)


def _with_negatives(args: Sequence[str], options: Collection[str]) -> list[str]:
    """The arguments with --size=-5x10 for --size -5x10, and so for all of these options that have two dashes.

    argparse takes a word that begins with a minus for a value only if it is a number.
    """
    made: list[str] = []
    for argument in args:
        if made and made[-1] in options and made[-1].startswith("--") and _NEGATIVE.match(argument):
            made[-1] += f"={argument}"
        else:
            made.append(argument)
    return made


def _with_values(args: Sequence[str] | None) -> list[str] | None:
    """The arguments with --tile=exact for --tile, and --tile=nearest for --tile nearest."""
    if args is None:
        return None
    made: list[str] = []
    for argument in args:
        if argument == "nearest" and made and made[-1] == "--tile=exact":
            made[-1] = "--tile=nearest"
        else:
            made.append("--tile=exact" if argument == "--tile" else argument)
    return made


class Version(argparse.Action):
    """Looks the version up only when asked: that takes longer than all of --help."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print the version and end."""
        from importlib.metadata import version

        parser.exit(0, f"kwatra {version('kwatra')}\n")


def file(text: str) -> Path:
    """A path that a file can have."""
    parts = [os.fsencode(part) for part in text.split(os.sep)]
    if not text or "\0" in text or max(map(len, parts)) > 255 or sum(map(len, parts)) + len(parts) > 4096:
        shown = text if len(text) <= 60 else f"{text[:60]}..."
        raise argparse.ArgumentTypeError(f"{shown!r} cannot be the name of a file; give another, of at most 255 bytes")
    return Path(text)


def mask(text: str) -> Path:
    """A mask's file, or not:FILE, which means its opposite."""
    file(text.removeprefix("not:"))
    return Path(text)


def size(text: str) -> tuple[int, int]:
    """WIDTHxHEIGHT, or one number for both, as (height, width)."""
    width, x, height = text.lower().partition("x")
    height = height if x else width
    if not (_is_whole(width) and _is_whole(height) and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text!r} is no size; write WIDTHxHEIGHT in pixels, for example 512x384")
    return int(height), int(width)


def levels(text: str) -> str | tuple[tuple[int, int], ...]:
    """SCALE:WIDTH,... as pairs, or "thesis"."""
    if text == "thesis":
        return text
    pairs = [part.split(":") for part in text.split(",")]
    if not all(len(pair) == 2 and all(map(_is_whole, pair)) for pair in pairs):
        raise argparse.ArgumentTypeError(f'{text!r} are no levels; write SCALE:WIDTH,... as "4:32,2:16,1:8", or thesis')
    return tuple((int(scale), int(width)) for scale, width in pairs)


def numbers(text: str) -> tuple[float, ...]:
    """Finite numbers with commas between them."""
    found = tuple(_number(part) for part in text.split(","))
    if not all(map(math.isfinite, found)):
        raise argparse.ArgumentTypeError(f"{text!r} are no numbers; write them with commas, as 90,180")
    return found


def scales(text: str) -> tuple[float, ...]:
    """Scales F,F,... or a range A:B of them, from A to B in five steps, each 0.1 to 10."""
    first, colon, last = text.partition(":")
    ends = [_number(part) for part in ((first, last) if colon else text.split(","))]
    if not all(0.1 <= end <= 10 for end in ends):
        raise argparse.ArgumentTypeError(f"{text!r} are no scales from 0.1 to 10; write F,F,... as 0.8,1.25, or A:B")
    if not colon or ends[0] == ends[1]:
        return tuple(ends[:1] if colon else ends)
    return tuple(ends[0] * (ends[1] / ends[0]) ** (step / 4) for step in range(5))


def position(text: str) -> tuple[int, int]:
    """A place X,Y in pixels."""
    x, _, y = text.partition(",")
    if not (_is_whole(x.removeprefix("-")) and _is_whole(y.removeprefix("-"))):
        raise argparse.ArgumentTypeError(f"{text!r} is no position; write X,Y in pixels, for example 40,80")
    return int(x), int(y)


def margins(text: str) -> tuple[int, int, int, int]:
    """Pixels on each side, or LEFT,TOP,RIGHT,BOTTOM."""
    parts = text.split(",")
    if len(parts) not in (1, 4) or not all(map(_is_whole, parts)) or not any(int(part) for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} are no margins; write pixels as 64, or LEFT,TOP,RIGHT,BOTTOM")
    left, top, right, bottom = (int(part) for part in parts * (4 // len(parts)))
    return left, top, right, bottom


def number(least: float, most: float, what: str = "number") -> Callable[[str], float]:
    """What reads numbers from `least` to `most`."""

    def parse(text: str) -> float:
        value = _number(text)
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is no {what} from {least:g} to {most:g}")
        return value

    return parse


def positive(text: str) -> float:
    """A finite number above 0."""
    value = _number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return value


def finite(text: str) -> float:
    """A number that is not infinite, above or below 0."""
    value = _number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no finite number; write one, for example 2.5")
    return value


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """What reads whole numbers from `least` on, up to `most`."""

    def parse(text: str) -> int:
        if not _is_whole(text) or not least <= int(text) <= (math.inf if most is None else most):
            end = "on" if most is None else f"to {most}"
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {least} {end}")
        return int(text)

    return parse


MOST_FRAMES = 10**12
"""More than any disk holds, and few enough that sentences can say what they would need."""


def frame_count(least: int) -> Callable[[str], int]:
    """What reads how many frames to make, from `least` to MOST_FRAMES."""
    return whole(least, MOST_FRAMES)


rate = number(0.1, 1000, "number of frames a second")
"""Frames a second, as many as videos can have."""


def add_tile(parser: argparse.ArgumentParser) -> None:
    """Add --tile; it is None, "exact" or "nearest"."""
    parser.add_argument("--tile", choices=("exact", "nearest"), metavar="", help="make an image that repeats without a "
        "seam in both directions; --tile nearest: in the nearest size that holds whole periods")  # fmt: skip


def add_scale(parser: argparse.ArgumentParser) -> None:
    """Add --scale, in the one way in which all commands read it."""
    parser.add_argument("--scale", type=scales, metavar="F,F,...|A:B", help="use scaled variants of the exemplar too: "
        "of these sizes, or of five from A to B times its own")  # fmt: skip


def add_common(
    parser: argparse.ArgumentParser, threads: int | None = None, device: bool = True, verbose: bool = False
) -> None:
    """Add what all commands that compute take.

    `threads`: how many by default, None for as many as cores. `device`: whether there is a choice of it. `verbose`:
    whether there are details to tell.
    """
    add = parser.add_argument
    if device:
        add("--device", choices=("cpu", "cuda"), default="cpu", help="where to compute (default: cpu)")
    add("--threads", type=whole(1, MOST_THREADS), default=threads, metavar="N",
        help=f"threads to use (default: {threads or 'as many as cores'})")  # fmt: skip
    add("--overwrite", action="store_true", help="replace files that exist")
    add("--save-recipe", type=file, metavar="FILE.toml", help="write what was done, and of which files: kwatra run "
        "does it again")  # fmt: skip
    if verbose:
        add("--verbose", action="store_true", help="tell more when done: how it went, and how good it is")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) < 4000
