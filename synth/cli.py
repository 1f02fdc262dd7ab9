"""The command line: `kwatra synth`, `fill`, `score`, `flow`, `animate`, `quilt`, `merge` and `patterns`.

Bad input ends with one sentence on stderr and exit code 2, Ctrl-C with 130. What takes long to import is imported
when a command runs, so that `--help` answers at once.
"""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn, TypeVar

from synth.commands.animate_arguments import add_animate
from synth.commands.parsing import add_common, levels, numbers, positive, size, whole
from synth.commands.patterns import add_patterns
from synth.commands.quilt_arguments import add_arguments

T = TypeVar("T")

_SYNTH_EPILOG = """examples:
  kwatra synth brick.png                               twice the size, as brick_synth.png
  kwatra synth brick.png -o wall.png --size 1024x768 --tile
  kwatra synth brick.png --also normal=brick_n.png     also writes brick_synth_normal.png
  kwatra synth field.png --guide field_labels.png=wanted_labels.png
"""
_FILL_EPILOG = """examples:
  kwatra fill wall.png --hole scratch.png              as wall_fill.png, from the rest of the wall
  kwatra fill wall.png --hole scratch.png --exemplar brick.png
"""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"kwatra: error: {message} (see {self.prog} --help)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    try:
        return _run(argv)
    except KeyboardInterrupt as interrupt:
        return _fail(str(interrupt) or "interrupted, nothing was written", 130)
    except BrokenPipeError:
        # whoever read the output has gone; python must not find that out again when it ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _run(argv: Sequence[str] | None) -> int:
    try:
        arguments = _parser().parse_args(argv)
        print(_command(arguments.command)(arguments))
        return 0
    except (ValueError, MemoryError, RuntimeError) as error:
        from kwatra.base.errors import InputError

        if isinstance(error, InputError):
            return _fail(str(error), 2)
        if _is_out_of_memory(error):
            return _fail("there is not enough memory; ask for a smaller --size", 2)
        raise
    finally:
        sys.stdout.flush()


def _command(name: str) -> Callable[[argparse.Namespace], str]:
    if name in ("quilt", "merge"):
        from synth.quilting import command

        return {"quilt": command.run_quilt, "merge": command.run_merge}[name]
    if name == "flow":
        from synth.commands.flow import run_flow

        return run_flow
    if name == "animate":
        from synth.commands.animate import run_animate

        return run_animate
    if name == "patterns":
        from synth.commands.patterns import run_patterns

        return run_patterns
    if name == "fill":
        from synth.commands.fill import run_fill

        return run_fill
    from synth.commands import synth as commands

    return {"synth": commands.run_synth, "score": commands.run_score}[name]


def _is_out_of_memory(error: Exception) -> bool:
    return isinstance(error, MemoryError) or "allocate memory" in str(error) or "out of memory" in str(error)


def _fail(sentence: str, code: int) -> int:
    print("kwatra: error:" if code == 2 else "kwatra:", " ".join(sentence.split()), file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="kwatra", description="Texture synthesis from examples.", allow_abbrev=False)
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_synth(commands)
    _add_fill(commands)
    _add_score(commands)
    _add_flow(commands)
    add_animate(commands)
    add_arguments(commands)
    add_patterns(commands)
    return parser


class _Version(argparse.Action):
    """Looks the version up only when asked: that takes longer than all of --help."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        parser.exit(0, f"kwatra {version('kwatra')}\n")


def _add_synth(commands: "argparse._SubParsersAction[_Parser]") -> None:
    parser = commands.add_parser(
        "synth",
        help="a new image from one or more exemplars of a texture",
        description="Make a new image that looks like the exemplars. PNG, JPEG, TIFF and EXR come out\n"
        "as they went in: gray or color, alpha, 8 or 16 bits or float.",
        epilog=_SYNTH_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("exemplars", nargs="+", type=Path, metavar="EXEMPLAR", help="image of the texture, or several of it")
    add("-o", "--output", type=Path, metavar="OUT", help="the file to write (default: EXEMPLAR_synth in this folder)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels, as 512x384 (default: twice the exemplar)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another image (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add("--tile", action="store_true", help="make an image that repeats without a seam in both directions")
    add("--start", type=Path, metavar="IMAGE", help="image to start from, of the size to make")
    add("--levels", type=levels, metavar="SCALE:WIDTH,...", help='"4:32,2:16,1:8": windows 32 wide at 1/4 size, and '
        'so on; or "thesis", the levels of Kwatra\'s thesis (default: planned from the exemplar)')  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored copies of the exemplars too")
    add("--rotate", type=numbers, default=(), metavar="DEG,...", help="use rotated copies too (--rotate=-90,90)")
    add("--scale", type=numbers, default=(), metavar="FACTOR,...", help="use scaled copies too")
    add("--progress-images", type=Path, metavar="DIR", help="write the image after each level into this folder")
    add("--energy", type=Path, metavar="FILE", help="write the energy per iteration as .csv or drawn as .png")
    add("--map", type=Path, metavar="FILE", help="write where each pixel comes from: .npy int32 (exemplar, y, x) by "
        "(3, H, W), or 16-bit .png with R = x, G = y, B = exemplar")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="carry a map of the exemplar along, exactly, "
        "to OUT_NAME; with several exemplars NAME=FILE1,FILE2; may be given again")  # fmt: skip
    add("--guide", metavar="MAP=MAP", help="EXEMPLAR_MAP=OUTPUT_MAP: put texture where the output's map is like the "
        "exemplar's (labels, a density, a direction); with several exemplars A,B=OUTPUT_MAP")  # fmt: skip
    add("--guide-weight", type=positive, default=1.0, metavar="W", help="what the guide counts beside the colors; "
        "0.1 to 0.3 suits maps that vary smoothly (default: 1)")  # fmt: skip
    add_common(parser)


def _add_fill(commands: "argparse._SubParsersAction[_Parser]") -> None:
    parser = commands.add_parser(
        "fill",
        help="fill a hole in an image with texture",
        description="Fill the hole in an image with the texture around it, or with that of exemplars.\n"
        "Pixels outside of the hole stay exactly as they are.",
        epilog=_FILL_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("image", type=Path, metavar="IMAGE", help="the image with a hole")
    add("--hole", type=Path, required=True, metavar="MASK", help="image of the same size, white where to fill")
    add("--exemplar", type=Path, action="append", default=[], metavar="FILE", help="fill from this image instead of "
        "from the rest of IMAGE; may be given again")  # fmt: skip
    add("-o", "--output", type=Path, metavar="OUT", help="the file to write (default: IMAGE_fill in this folder)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another filling (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_common(parser)


def _add_score(commands: "argparse._SubParsersAction[_Parser]") -> None:
    parser = commands.add_parser(
        "score",
        help="how well outputs match their exemplar",
        description="Measure synthesized images against their exemplar.",
        allow_abbrev=False,
    )
    parser.add_argument("exemplar", type=Path, metavar="EXEMPLAR", help="image of the texture")
    parser.add_argument("outputs", nargs="+", type=Path, metavar="OUTPUT", help="image to measure")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def _add_flow(commands: "argparse._SubParsersAction[_Parser]") -> None:
    parser = commands.add_parser(
        "flow",
        help="a flow field by name or from a file, as a file or a picture",
        description="Write a flow field as a file of another format or draw a picture of it.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("field", metavar="FIELD", help="uniform:ANGLE, rotation, sink, ... (another name lists them all), or a file")
    add("-o", "--output", type=Path, metavar="OUT", help="the file to write: .flo, .png (KITTI), .npy or .npz")
    add("--picture", type=Path, metavar="FILE", help="draw it into this image: hue is direction, full color is fastest")
    add("--arrows", type=whole(0), default=16, metavar="PX", help="distance of the arrows in it (default: 16; 0: none)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: 256x256; a file's own)")
    add("--speed", type=float, metavar="PX", help="px per frame of the fastest pixel (default: 2; a file's own)")
    add("--frames", type=whole(1), metavar="N", help="how many in time (default: 1; as many as a file holds)")
    add("--overwrite", action="store_true", help="replace files that exist")


if __name__ == "__main__":
    sys.exit(main())
