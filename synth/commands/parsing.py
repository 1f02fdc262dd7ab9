"""What the arguments of the command line mean; ArgumentTypeError says what they cannot read."""

import argparse
from collections.abc import Callable


def size(text: str) -> tuple[int, int]:
    """WIDTHxHEIGHT as (height, width)."""
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text!r} is no size; write WIDTHxHEIGHT in pixels, for example 512x384")
    return int(height), int(width)


def levels(text: str) -> str | tuple[tuple[int, int], ...]:
    """SCALE:WIDTH,... as pairs, or "thesis"."""
    if text == "thesis":
        return text
    pairs = [part.split(":") for part in text.split(",")]
    if not all(len(pair) == 2 and all(number.isdecimal() for number in pair) for pair in pairs):
        raise argparse.ArgumentTypeError(f'{text!r} are no levels; write SCALE:WIDTH,... as "4:32,2:16,1:8", or thesis')
    return tuple((int(scale), int(width)) for scale, width in pairs)


def numbers(text: str) -> tuple[float, ...]:
    """Numbers with commas between them."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} are no numbers; write them with commas, as 90,180") from None


def positive(text: str) -> float:
    """A finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return value


def rate(text: str) -> float:
    """Frames a second, as many as videos can have."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.1 <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of frames a second from 0.1 to 1000")
    return value


def whole(least: int) -> Callable[[str], int]:
    """What reads whole numbers from `least` on."""

    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {least} on")
        return int(text)

    return parse


def add_common(parser: argparse.ArgumentParser, threads: int | None = None, device: bool = True) -> None:
    """Add what all commands that compute take.

    `threads`: how many by default, None for as many as cores. `device`: whether there is a choice of it.
    """
    add = parser.add_argument
    if device:
        add("--device", choices=("cpu", "cuda"), default="cpu", help="where to compute (default: cpu)")
    add("--threads", type=whole(1), default=threads, metavar="N",
        help=f"threads to use (default: {threads or 'as many as cores'})")  # fmt: skip
    add("--overwrite", action="store_true", help="replace files that exist")
