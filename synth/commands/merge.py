"""`kwatra merge`: images laid over a background along the best seams."""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, quilting
from synth.commands.checks import check_distinct, finish, set_up
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, add_common, file, position
from synth.commands.sewing import add_blending, extra_writers, seams_kind, settings_of
from synth.commands.telling import contributions, details
from synth.saying import note
from synth.words import listed

if TYPE_CHECKING:
    from torch import Tensor

LOADS = ("synth.quilting.merging", "synth.quilting.draw", "synth.io.images")

WHOLE = 0.95
"""An overlay that shows so much of itself is likely to hide what was to be seen."""

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
    add("-o", "--output", type=file, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "BACKGROUND_merge in this folder)")  # fmt: skip
    add("--plain", action="store_true", help="cost of a seam by color alone, not less where the images are busy")
    add_blending(parser, "default: 0")
    add("--seams", type=file, metavar="FILE", help="also write the result with its seams drawn in red")
    add_common(parser, device=False, verbose=True)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    overlays, at, keep, spare = arguments.overlays, arguments.at or [], arguments.keep, arguments.spare or []
    at = at or [(0, 0)] * len(overlays)
    for name, given in (("--at", at), ("--keep", keep), ("--spare", spare or overlays)):
        if len(given) != len(overlays):
            raise synth.InputError(f"there are {len(overlays)} overlays but {len(given)} of {name}; give one for each")
    pictures = [io.read_image(path) for path in (arguments.background, *overlays)]
    images, kind = io.raised(pictures, (arguments.background, *overlays))
    images = [io.premultiplied(image, kind) for image in images]
    masks = [[io.read_mask(path) for path in paths] for paths in (keep, spare)]
    output = output_of(arguments.output, f"{arguments.background.stem}_merge{arguments.background.suffix}")
    io.check_output(output, kind, arguments.overwrite)
    check_distinct([path for path in (output, arguments.seams) if path is not None])
    if arguments.seams is not None:
        io.check_output(arguments.seams, seams_kind(), arguments.overwrite)
    spares: list[Tensor | None] = list(masks[1]) or [None] * len(overlays)
    layers = [quilting.Overlay(*parts) for parts in zip(images[1:], at, masks[0], spares, strict=True)]
    settings = settings_of(quilting.QuiltSettings(), arguments, normalized=not arguments.plain)
    began = time.perf_counter()
    result = quilting.merge(images[0], layers, settings)
    took = time.perf_counter() - began
    _hint_at_sparing(overlays, layers, result)
    image = io.straight(result.image, kind)
    writers = {output: io.image_writer(output, image, kind)} | extra_writers(arguments, result)
    finish(writers, arguments.overwrite)
    height, width = result.patch.shape
    rows = {"file": output.resolve(), "pixels": kind, "seams cost": f"{result.cost:.1f} color ranges times pixels"}
    told = contributions([arguments.background, *overlays], result.source.numpy())
    more = details(rows) if arguments.verbose else ""
    return f"wrote {listed(list(writers))}: {width}x{height} in {took:.1f} s{told}{more}"


def _hint_at_sparing(paths: "Sequence[Path]", layers: "Sequence[quilting.Overlay]", result: "quilting.Quilt") -> None:
    """Say which overlays hide all that they lie on, as one does that nothing is said to be spared of."""
    for number, (path, layer) in enumerate(zip(paths, layers, strict=True), 1):
        top, left = layer.at[1], layer.at[0]
        height, width = layer.image.shape[1:]
        under = result.source[max(top, 0) : max(top + height, 0), max(left, 0) : max(left + width, 0)]
        if layer.spare is None and under.numel() and bool((under == number).float().mean() > WHOLE):
            note(f"{path} covers nearly all that it lies on; mark with --spare what is to show the background")
