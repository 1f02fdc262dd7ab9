"""`kwatra tile`: one picture made to repeat without a seam, with the maps that belong to it."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

from synth import io, texture
from synth.commands.checks import check_distinct, finish, set_up
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, add_common, file, whole
from synth.commands.progress import work_line
from synth.saying import note
from synth.words import listed

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Writer

LOADS = ("synth.texture.tiling", "synth.texture.maps")

_EPILOG = """examples:
  kwatra tile wall.png                                 as wall_tile.png, of the same size
  kwatra tile wall.png --also normal=wall_n.png --also height=wall_h.tif
  kwatra tile bricks.png --crop                        cut first to whole rows and columns of bricks
  kwatra tile border.png --axes x                      repeats from left to right only
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "tile",
        help="make a picture repeat without a seam, changing as little as can be",
        description="Make this very picture tile: a band along its borders is sewn anew from patches of the picture,\n"
        "everything else stays as the file holds it, bit for bit. Light that falls unevenly on the picture is taken\n"
        "out of all of it before.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("image", type=file, metavar="IMAGE", help="the picture")
    add("-o", "--output", type=file, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "IMAGE_tile in this folder)")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="a map of the picture that is to tile with "
        "it, exactly, as OUT_NAME; may be given again")  # fmt: skip
    add("--axes", choices=("x", "y", "xy"), default="xy", help="where it repeats: x from left to right, y from top to "
        "bottom (default: xy)")  # fmt: skip
    add("--band", type=whole(2), metavar="PX", help="change pixels up to so far from the border (default: by the size "
        "of the texture's elements, 12 to 64)")  # fmt: skip
    add("--crop", action="store_true", help="cut the picture first to whole periods of a texture that repeats")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another seam (default: 0)")
    add("--map", type=file, metavar="FILE", help="write where each pixel comes from: .npy or .png, as of kwatra synth")
    add_common(parser, device=False)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    path = arguments.image
    array, kind = io.read_array(path)
    output = output_of(arguments.output, f"{path.stem}_tile{path.suffix}")
    size = (array.shape[0], array.shape[1])
    maps = [texture.read_map(request, [size], output) for request in arguments.also]
    io.check_output(output, kind, arguments.overwrite)
    for carried in maps:
        io.check_output(carried.output, carried.kind, arguments.overwrite)
    if arguments.map is not None:
        texture.check_source_output(arguments.map, [size], arguments.overwrite)
    check_distinct([*(p for p in (output, arguments.map) if p is not None), *(carried.output for carried in maps)])
    began, colors = time.perf_counter(), io.mixed(array, kind)
    if not arguments.crop:
        _hint_at_cropping(io.to_pixels(array), arguments.axes)
    with work_line(path.name) as report:
        made = texture.tile(
            colors,
            axes=arguments.axes,
            band=arguments.band,
            crop=arguments.crop,
            seed=arguments.seed,
            report=report,
        )
    took = time.perf_counter() - began
    tiled, sewn = made.take(array), (made.image != made.take(colors)).any(-1)
    tiled[sewn] = io.unmixed(made.image, kind)[sewn]
    writers: dict[Path, Writer] = {output: io.array_writer(output, tiled, kind)}
    writers |= {carried.output: texture.map_writer(carried, made.source) for carried in maps}
    if arguments.map is not None:
        writers[arguments.map] = texture.source_writer(arguments.map, made.source)
    finish(writers, arguments.overwrite)
    height, width = tiled.shape[:2]
    top, left = (int(places[height // 2, width // 2]) for places in made.source[1:])
    there = array[top - height // 2 :, left - width // 2 :][:height, :width]
    changed = (tiled != there).any(-1).mean()
    how = "its light, which falls unevenly, was evened" if made.even else f"{changed:.0%} of it changed"
    return f"wrote {listed(list(writers))}: {width}x{height}, {how}, seed {arguments.seed}, in {took:.1f} s"


def _hint_at_cropping(pixels: "Tensor", axes: str) -> None:
    """Say so where the picture repeats, but does not hold whole periods."""
    size = (pixels.shape[1], pixels.shape[2])
    good = texture.whole_size([pixels], size, axes, crop=True, quickly=True)
    if good is not None and good != size:
        note(f"the texture repeats, and {good[1]}x{good[0]} holds whole periods; --crop cuts the picture to that")
