"""`kwatra score`: how well outputs match their exemplar."""

import argparse
import json

import synth
from synth import io
from synth.commands.parsing import Subparsers, file
from synth.commands.report import score_table

LOADS = ("synth.io.images", "kwatra.measure")


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "score",
        help="how well outputs match their exemplar",
        description="Measure synthesized images against their exemplar.",
    )
    parser.add_argument("exemplar", type=file, metavar="EXEMPLAR", help="image of the texture")
    parser.add_argument("outputs", nargs="+", type=file, metavar="OUTPUT", help="image to measure")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def run(arguments: argparse.Namespace) -> str:
    """A table, or JSON of one object per output file."""
    from kwatra import measure

    exemplar = io.read_image(arguments.exemplar)
    outputs = {str(path): io.read_image(path) for path in arguments.outputs}
    for path, output in outputs.items():
        if len(output.pixels) != len(exemplar.pixels):
            raise synth.InputError(
                f"{path} holds {output.kind} but {arguments.exemplar} holds {exemplar.kind}; "
                "an output has its exemplar's channels"
            )
    scores = {path: measure(output.pixels, exemplar.pixels) for path, output in outputs.items()}
    if arguments.json:
        return json.dumps([{"output": path, **row} for path, row in scores.items()], indent=2)
    return score_table(scores)
