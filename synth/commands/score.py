"""`kwatra score`: how well outputs match their exemplar."""

import argparse
import json
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.parsing import Subparsers, file
from synth.commands.report import score_table
from synth.words import counted

if TYPE_CHECKING:
    from synth.io import Picture

LOADS = ("synth.io.images", "kwatra.measure")

_MOST_PIXELS, _MOST_CHANNELS = 2**24, 16
"""Time grows with pixels and with the cube of channels: these take a minute and some seconds on one core."""

_COLUMNS = """columns:
  forward      distance from what is seen in the output to the likest in the exemplar: lower is better, 0 is perfect
  coverage     the same from the exemplar to the output, whether all of it appears: lower is better
  wasserstein  whether all appears as often as in the exemplar: lower is better
  sharpness    gradients of the output over those of the exemplar: 1 is right, below is blurred, above is too rough
  copy         part of the exemplar that the output's verbatim copies are large on average: lower is more of its own
  use          how evenly all parts of the exemplar are used, 0 to 1: higher is better
  overall      mean of forward, coverage, wasserstein and what sharpness is off 1: lower is better, to be read with copy
Distances are in standard deviations of the exemplar: 1 is hopeless.
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "score",
        help="how well outputs match their exemplar",
        description="Measure synthesized images against their exemplar.",
        epilog=_COLUMNS,
    )
    parser.add_argument("exemplar", type=file, metavar="EXEMPLAR", help="image of the texture")
    parser.add_argument("outputs", nargs="+", type=file, metavar="OUTPUT", help="image to measure")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def run(arguments: argparse.Namespace) -> str:
    """A table, or JSON of one object per output file."""
    from kwatra import measure

    exemplar = io.read_image(arguments.exemplar)
    outputs = {str(path): io.read_image(path) for path in arguments.outputs}
    _check(str(arguments.exemplar), exemplar)
    for path, output in outputs.items():
        _check(path, output)
        if len(output.pixels) != len(exemplar.pixels):
            raise synth.InputError(
                f"{path} holds {output.kind} but {arguments.exemplar} holds {exemplar.kind}; "
                "an output has its exemplar's channels"
            )
    scores = {path: measure(output.pixels, exemplar.pixels) for path, output in outputs.items()}
    if arguments.json:
        return json.dumps([{"output": path, **row} for path, row in scores.items()], indent=2)
    return score_table(scores)


def _check(path: str, picture: "Picture") -> None:
    """Refuse what would take hours."""
    channels, height, width = picture.pixels.shape
    if height * width > _MOST_PIXELS or channels > _MOST_CHANNELS:
        raise synth.InputError(
            f"{path} is {width}x{height} with {counted(channels, 'channel')}; at most 2^24 pixels (4096x4096) and "
            f"{_MOST_CHANNELS} channels are measured, so crop it or leave some out"
        )
