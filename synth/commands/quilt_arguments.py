"""The arguments of `kwatra quilt` and `kwatra merge`; imports nothing heavy, so that --help answers at once."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from synth.commands.parsing import add_common, size, whole

_QUILT_EPILOG = """examples:
  kwatra quilt bricks.png                                 twice the size, as bricks_quilt.png
  kwatra quilt pebbles.png --placement sub --tile
  kwatra quilt fountain.mp4 --loop                        an endless loop by one seam in time
  kwatra quilt fire/ -o fire.mp4 --mode time --frames 300
  kwatra quilt river.mp4 --mode spacetime --size 400x300 --loop
"""
_MERGE_EPILOG = """examples:
  kwatra merge river.png raft.png --at 40,80 --keep raft_keep.png -o both.png
  kwatra merge leaves.png a.png b.png --at 0,0 --keep a_keep.png --at 90,10 --keep b_keep.png
"""


def add_arguments(subparsers: Any) -> None:
    """Add both commands to an argparse subparsers object."""
    _add_quilt(subparsers)
    _add_merge(subparsers)


def _add_quilt(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "quilt",
        help="a new image or video sewn from patches of an exemplar",
        description="Graph-cut quilting: patches of the exemplar laid over each other along the best seams.",
        epilog=_QUILT_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("exemplar", type=Path, metavar="EXEMPLAR", help="an image, a video (.mp4, .gif) or a folder of frames")
    add("-o", "--output", type=Path, metavar="OUT", help="the file or folder to write (default: EXEMPLAR_quilt)")
    add("--size", type=size, metavar="WxH", help="size in pixels (default: an image's doubled, a video's own)")
    add("--placement", choices=("random", "whole", "sub"), help="how patches are placed: whole for structured "
        "textures, sub for stochastic ones and motion (default: whole; videos: by mode)")  # fmt: skip
    add("--k", type=float, metavar="K", help="randomness of the choice of offsets, 0.001 to 1 (default: 0.01)")
    add("--refine", type=whole(0), metavar="STEPS", help="at most so many patches that mend seams (default: 60)")
    add("--seconds", type=float, metavar="S", help="stop refining after this time")
    add("--edges", action=argparse.BooleanOptionalAction, help="let seams prefer busy places: normalize their cost by "
        "the gradient (default: for videos only)")  # fmt: skip
    add("--tile", action="store_true", help="make a picture that repeats without a seam in both directions")
    _add_copies(parser)
    _add_blending(parser, "default: 0, and 1 for videos")
    _add_video(parser)
    add("--seams", type=Path, metavar="FILE", help="also write the result with its seams drawn in red")
    add("--map", type=Path, metavar="FILE", help="also write where each pixel is from: .npy, int32, (copy, [t,] y, x)")
    add_common(parser, device=False)
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another result (default: 0)")


def _add_copies(parser: argparse.ArgumentParser) -> None:
    """What else than the exemplar itself is copied from."""
    add = parser.add_argument
    add("--rotate", type=_angles, nargs="?", const=(90.0, 180.0, 270.0), metavar="DEG,...", help="use rotated copies "
        "too (without angles: by quarter turns; --rotate=-20,20)")  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored copies too")
    add("--scale", type=_scales, metavar="A:B", help="use scaled copies too, from A to B times the size")
    add("--perspective", action="store_true", help="let the scale go from A at the top to B at the bottom")


def _add_video(parser: argparse.ArgumentParser) -> None:
    """What only videos have."""
    add = parser.add_argument
    add("--mode", choices=("transition", "time", "spacetime"), help="videos: join the clip to itself, displace it in "
        "time, or in space and time (default: transition; spacetime where --size differs)")  # fmt: skip
    add("--frames", type=whole(0), metavar="N", help="videos: length (default: one loop, or twice the clip)")
    add("--loop", action="store_true", help="videos: make the end meet the beginning")
    add(
        "--hold",
        type=whole(0),
        metavar="K",
        help="videos: frames that a loop holds at its ends (default: 10, or half a short clip)",
    )
    add("--fps", type=float, metavar="F", help="videos: frames a second (default: as the file says; a folder: 25)")


def _add_blending(parser: argparse.ArgumentParser, default: str) -> None:
    blend = parser.add_mutually_exclusive_group()
    blend.add_argument("--feather", type=float, metavar="S", help=f"blend seams by a Gaussian of S pixels ({default})")
    blend.add_argument("--spline", action="store_true", help="blend seams by multi-resolution splining")


def _add_merge(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "merge",
        help="merge images along the best seam",
        description="Lay images over a background; the seams run where the images are alike or where edges hide them.",
        epilog=_MERGE_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("background", type=Path, metavar="BACKGROUND", help="the image that the others are laid on")
    add("overlays", type=Path, nargs="+", metavar="OVERLAY", help="an image to lay on it")
    add("--at", type=_position, action="append", metavar="X,Y", help="where an overlay's top left pixel goes "
        "(--at=-5,3 for a negative x); once for each overlay, in order (default: 0,0)")  # fmt: skip
    add("--keep", type=Path, action="append", required=True, metavar="MASK", help="white where the overlay must show; "
        "an image of the overlay's size; once for each overlay")  # fmt: skip
    add("--spare", type=Path, action="append", metavar="MASK", help="white where the background must show; as --keep")
    add("-o", "--output", type=Path, metavar="OUT", help="the file to write (default: BACKGROUND_merge)")
    add("--plain", action="store_true", help="cost of a seam by colour alone, not less where the images are busy")
    _add_blending(parser, "default: 0")
    add("--seams", type=Path, metavar="FILE", help="also write the result with its seams drawn in red")
    add_common(parser, device=False)


def _angles(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} are no angles; write DEG,DEG,... (--rotate=-20,20), or nothing and --rotate last"
        ) from None


def _scales(text: str) -> tuple[float, float]:
    try:
        first, last = text.split(":")
        return float(first), float(last)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no range of scales; write A:B, for example 0.5:1") from None


def _position(text: str) -> tuple[int, int]:
    try:
        x, y = text.split(",")
        return int(x), int(y)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no position; write X,Y in pixels, for example 40,80") from None
