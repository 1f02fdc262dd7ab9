"""The arguments of `kwatra animate`; imports nothing heavy, so that --help answers at once."""

import argparse
from pathlib import Path
from typing import Any

from synth.commands.parsing import add_common, rate, size, whole

FRAMES = 100

_EPILOG = """examples:
  kwatra animate brick.png --flow rotation                  100 frames, as brick_rotation.mp4
  kwatra animate brick.png --flow uniform:90 --loop 60 -o falling.gif
  kwatra animate leaves.png --flow wind.flo --speed 2 --frames 1000 -o frames/
  kwatra animate sand.png --flow uniform --obstacle disc --fill-from left
  kwatra animate leaves.png --flow wind.flo --speed 2 --frames 2000 -o frames/ --resume
"""

Obstacle = Path | tuple[float, ...]
"""An image, or a disc: (x, y, radius), or () for the one in the frame's middle."""


def add_animate(subparsers: Any) -> None:
    """Add the command to an argparse subparsers object."""
    parser = subparsers.add_parser(
        "animate",
        help="a texture that flows along a field",
        description="Make a video, or a folder of frames, of a texture that flows along a field without wearing out.\n"
        "Every frame is kept as soon as it is whole: what was interrupted, --resume goes on with.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("exemplar", type=Path, metavar="EXEMPLAR", help="image of the texture")
    add("--flow", required=True, metavar="FIELD", help="uniform:ANGLE, rotation, sink, ... (another name lists them "
        "all), or a file: .flo, .png (KITTI), .npy or .npz")  # fmt: skip
    add("--speed", type=float, metavar="PX", help="px per frame of the fastest pixel (default: 2; a file's own)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: that of the files given, or "
        "256x256)")  # fmt: skip
    add("--resample", action="store_true", help="stretch a file's flow over frames of another size")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--frames", type=whole(1), metavar="N", help=f"how many frames (default: {FRAMES})")
    length.add_argument("--loop", type=whole(2), metavar="N", help="N frames of which the last leads into the first")
    add("--obstacle", type=obstacle, metavar="WHAT", help="what is flowed around: an image, white where the obstacle "
        "is; or disc, in the middle; or disc:X,Y,RADIUS in pixels")  # fmt: skip
    begin = parser.add_mutually_exclusive_group()
    begin.add_argument("--first", type=Path, metavar="IMAGE", help="a picture to begin with, of the frames' size")
    begin.add_argument("--fill-from", choices=("left", "right", "top", "bottom", "all"), help="begin with an empty "
        "frame that texture enters from there")  # fmt: skip
    add("-o", "--output", type=Path, metavar="OUT", help="an .mp4 or .gif to write, or a folder for PNG frames, TIFF "
        "where the exemplar needs it (default: EXEMPLAR_FIELD.mp4 in this folder)")  # fmt: skip
    add("--fps", type=rate, default=25.0, metavar="F", help="frames a second of a video (default: 25)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another texture (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add("--resume", action="store_true", help="go on after the last frame of an interrupted run, or a folder's; the "
        "result is the same as without the break")  # fmt: skip
    add_common(parser, threads=1)  # one frame's steps are too small to share


def obstacle(text: str) -> Obstacle:
    """`disc`, `disc:X,Y,RADIUS` or a file."""
    name, colon, rest = text.partition(":")
    if name != "disc":
        return Path(text)
    try:
        numbers = tuple(float(part) for part in rest.split(",")) if colon else ()
    except ValueError:
        numbers = (0.0,)
    if colon and not (len(numbers) == 3 and all(abs(n) < float("inf") for n in numbers) and numbers[2] > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no disc; write disc, or disc:X,Y,RADIUS as disc:80,60,20")
    return numbers
