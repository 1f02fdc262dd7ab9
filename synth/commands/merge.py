"""`kwatra merge`: images laid over a background along the best seams."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, quilting
from synth.commands.checks import check_distinct, finish, set_up
from synth.commands.parsing import Subparsers, add_common, file, position
from synth.commands.sewing import add_blending, extra_writers, seams_kind, settings_of
from synth.words import listed

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Kind, Picture

LOADS = ("synth.quilting.merging", "synth.quilting.draw", "synth.io.images")

_EPILOG = """examples:
  kwatra merge river.png raft.png --at 40,80 --keep raft_keep.png -o both.png
  kwatra merge leaves.png a.png b.png --at 0,0 --keep a_keep.png --at 90,10 --keep b_keep.png
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "merge",
        help="merge images along the best seam",
        description="Lay images over a background; the seams run where the images are alike or where edges hide them.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("background", type=file, metavar="BACKGROUND", help="the image that the others are laid on")
    add("overlays", type=file, nargs="+", metavar="OVERLAY", help="an image to lay on it")
    add("--at", type=position, action="append", metavar="X,Y", help="where an overlay's top left pixel goes "
        "(--at=-5,3 for a negative x); once for each overlay, in order (default: 0,0)")  # fmt: skip
    add("--keep", type=file, action="append", required=True, metavar="MASK", help="white where the overlay must show; "
        "an image of the overlay's size; once for each overlay")  # fmt: skip
    add("--spare", type=file, action="append", metavar="MASK", help="white where the background must show; as --keep")
    add("-o", "--output", type=file, metavar="OUT", help="the file to write (default: BACKGROUND_merge)")
    add("--plain", action="store_true", help="cost of a seam by color alone, not less where the images are busy")
    add_blending(parser, "default: 0")
    add("--seams", type=file, metavar="FILE", help="also write the result with its seams drawn in red")
    add_common(parser, device=False)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    overlays, at, keep, spare = arguments.overlays, arguments.at or [], arguments.keep, arguments.spare or []
    at = at or [(0, 0)] * len(overlays)
    for name, given in (("--at", at), ("--keep", keep), ("--spare", spare or overlays)):
        if len(given) != len(overlays):
            raise synth.InputError(f"there are {len(overlays)} overlays but {len(given)} of {name}; give one for each")
    pictures = [io.read_image(path) for path in (arguments.background, *overlays)]
    images, kind = _alike(pictures)
    masks = [[io.read_mask(path) for path in paths] for paths in (keep, spare)]
    output = arguments.output or Path(f"{arguments.background.stem}_merge{arguments.background.suffix}")
    io.check_output(output, kind, arguments.overwrite)
    check_distinct([path for path in (output, arguments.seams) if path is not None])
    if arguments.seams is not None:
        io.check_output(arguments.seams, seams_kind(), arguments.overwrite)
    spares: list[Tensor | None] = list(masks[1]) or [None] * len(overlays)
    layers = [quilting.Overlay(*parts) for parts in zip(images[1:], at, masks[0], spares, strict=True)]
    settings = settings_of(quilting.QuiltSettings(), arguments, normalized=not arguments.plain)
    result = quilting.merge(images[0], layers, settings)
    writers = {output: io.image_writer(output, result.image, kind)} | extra_writers(arguments, result)
    finish(writers)
    return f"wrote {listed(list(writers))}: seams cost {result.cost:.1f}"


def _alike(pictures: "Sequence[Picture]") -> "tuple[list[Tensor], Kind]":
    """Images of one kind: gray ones become color where any is; alpha stays only if all have it."""
    kinds = {picture.kind.channels for picture in pictures}
    if len(kinds) == 1:
        return [picture.pixels for picture in pictures], pictures[0].kind
    best = next((p.kind for p in pictures if p.kind.channels == ("R", "G", "B")), seams_kind())
    return [_color(picture) for picture in pictures], best


def _color(picture: "Picture") -> "Tensor":
    names = picture.kind.channels
    if names[:3] == ("R", "G", "B"):
        return picture.pixels[:3]
    if names[0] == "Y":
        return picture.pixels[:1].expand(3, -1, -1)
    raise synth.InputError(
        f"an image has the channels {', '.join(names)}, which cannot be merged with others; convert it to RGB"
    )
