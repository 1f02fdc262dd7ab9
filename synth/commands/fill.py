"""`kwatra fill`: a hole in an image, filled with texture. Pixels outside of it stay as the file holds them."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import finish, set_up
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, add_common, file, target, whole
from synth.commands.progress import progress_line
from synth.commands.telling import contributions, details, of_result
from synth.words import counted

if TYPE_CHECKING:
    from synth.io import Array, Kind

LOADS = ("synth.texture.filling", "synth.io.images")

_EPILOG = """examples:
  kwatra fill wall.png --hole scratch.png              as wall_fill.png, from the rest of the wall
  kwatra fill wall.png --hole scratch.png --exemplar brick.png
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "fill",
        help="fill a hole in an image with texture",
        description="Fill the hole in an image with the texture around it, or with that of exemplars.\n"
        "Pixels outside of the hole stay exactly as they are.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("image", type=file, metavar="IMAGE", help="the image with a hole")
    add("--hole", type=file, required=True, metavar="MASK", help="image of the same size, white where to fill")
    add("--exemplar", type=file, action="append", default=[], metavar="FILE", help="fill from this image instead of "
        "from the rest of IMAGE; may be given again")  # fmt: skip
    add("-o", "--output", type=target, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "IMAGE_fill in this folder)")  # fmt: skip
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another filling (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_common(parser, verbose=True)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write the image; returns the summary."""
    set_up(arguments)
    path = arguments.image
    image, kind = io.read_array(path)
    hole = io.read_mask(arguments.hole).numpy()
    if hole.shape != image.shape[:2]:
        raise synth.InputError(
            f"{arguments.hole} is {hole.shape[1]}x{hole.shape[0]} but {path} {image.shape[1]}x{image.shape[0]}; "
            "a hole's mask has its image's size"
        )
    if not hole.any():
        raise synth.InputError(f"{arguments.hole} is black everywhere; it is white where {path} is to be filled")
    exemplars = [_exemplar(each, path, kind) for each in arguments.exemplar]
    output = output_of(arguments.output, f"{path.stem}_fill{path.suffix}")
    io.check_output(output, kind, arguments.overwrite)
    began = time.perf_counter()
    with progress_line(f"{path.name}, {counted(int(hole.sum()), 'pixel')}") as callback:
        filled = texture.fill(
            io.mixed(image, kind),
            hole,
            exemplar=[io.mixed(exemplar, kind) for exemplar in exemplars] or None,
            preset=arguments.preset,
            seed=arguments.seed,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    image[hole] = io.unmixed(filled.image, kind)[hole]
    finish({output: io.array_writer(output, image, kind)})
    rows = {"file": output.resolve(), "pixels": kind, "preset": arguments.preset, **of_result(filled.result)}
    more = details(rows) if arguments.verbose else ""
    told = contributions(arguments.exemplar, filled.source[0][hole])
    seed = arguments.seed
    return f"wrote {output}: {counted(int(hole.sum()), 'pixel')} filled, seed {seed}, in {took:.1f} s{told}{more}"


def _exemplar(path: Path, image: Path, kind: "Kind") -> "Array":
    array, own = io.read_array(path)
    if (own.dtype, own.channels) != (kind.dtype, kind.channels):
        raise synth.InputError(f"{path} holds {own} but {image} holds {kind}; save the exemplar like the image")
    return array
