"""`kwatra fill`: a hole in an image or video, filled with texture. Pixels outside of it stay as the file holds them."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import check_distinct, check_size, finish, set_up
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, add_common, file, margins, mask, whole
from synth.commands.progress import progress_line
from synth.commands.telling import contributions, details, of_result
from synth.words import counted, listed

if TYPE_CHECKING:
    from synth.io import Array, Kind, Writer
    from synth.texture import Map

LOADS = ("synth.texture.filling", "synth.texture.maps")

TRANSPARENT = 0.5
"""What is more transparent than this is a hole, where no mask says what is; as in masks made of alpha."""

_EPILOG = """examples:
  kwatra fill wall.png --hole scratch.png              as wall_fill.png, from the rest of the wall
  kwatra fill wall.png --hole scratch.png --exemplar brick.png
  kwatra fill cut_out.png                              what is transparent
  kwatra fill stream.mp4 --hole branch.png             in every frame; a video or folder of masks: in space and time
  kwatra fill wall.png --extend 64                     64 pixels more on each side
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "fill",
        help="fill a hole in an image or video with texture",
        description="Fill the hole in an image or video with the texture around it, or with that of exemplars.\n"
        "Pixels outside of the hole stay exactly as they are.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("image", type=file, metavar="IMAGE", help="the image with a hole; or a video or folder of frames")
    add("--hole", type=mask, metavar="MASK", help="image of the same size, white where to fill, or a video of the "
        "same length; not:MASK is the opposite (default: what is transparent in IMAGE)")  # fmt: skip
    add("--extend", type=margins, metavar="PX", help="make the image larger by so many pixels on each side, or by "
        "LEFT,TOP,RIGHT,BOTTOM, and fill them")  # fmt: skip
    add("--exemplar", type=file, action="append", default=[], metavar="FILE", help="fill from this image instead of "
        "from the rest of IMAGE; may be given again")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "IMAGE_fill in this folder)")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="fill a map of the image likewise, exactly, "
        "as OUT_NAME; with --exemplar NAME=FILE,FILE1,... the exemplars' too; may be given again")  # fmt: skip
    add("--map", type=file, metavar="FILE", help="write where each pixel comes from: .npy or .png, as of kwatra synth; "
        "number 0 is the image, from 1 on the exemplars")  # fmt: skip
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another filling (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_common(parser, verbose=True)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write the image; returns the summary."""
    set_up(arguments)
    path = arguments.image
    if io.is_video(path):
        from synth.commands.fill_video import fill_video

        return fill_video(arguments)
    image, kind = io.read_array(path)
    exemplars = [_exemplar(each, path, kind) for each in arguments.exemplar]
    output = output_of(arguments.output, f"{path.stem}_fill{path.suffix}")
    maps = _maps(arguments, output, kind, [image, *exemplars])
    image, hole = _extended(image, _hole(arguments, image, kind), arguments.extend)
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
    source = _source(filled.source, hole, arguments)
    writers: dict[Path, Writer] = {output: io.array_writer(output, image, kind)}
    writers |= {carried.output: texture.map_writer(carried, source) for carried in maps}
    if arguments.map is not None:
        writers[arguments.map] = texture.source_writer(arguments.map, source)
    finish(writers, arguments.overwrite)
    rows = {"file": output.resolve(), "pixels": kind, "preset": arguments.preset, **of_result(filled.result)}
    more = details(rows) if arguments.verbose else ""
    told = contributions(arguments.exemplar, filled.source[0][hole])
    size = f"{hole.shape[1]}x{hole.shape[0]}, {counted(int(hole.sum()), 'pixel')} filled"
    return f"wrote {listed(list(writers))}: {size}, seed {arguments.seed}, in {took:.1f} s{told}{more}"


def _hole(arguments: argparse.Namespace, image: "Array", kind: "Kind") -> "Array":
    """Where the image (H, W, C) is to be filled, boolean (H, W)."""
    import numpy as np

    path = arguments.image
    if arguments.hole is not None:
        hole: Array = io.read_mask(arguments.hole).numpy()
        if hole.shape != image.shape[:2]:
            raise synth.InputError(
                f"{arguments.hole} is {hole.shape[1]}x{hole.shape[0]} but {path} {image.shape[1]}x{image.shape[0]}; "
                "a hole's mask has its image's size"
            )
        if not hole.any():
            raise synth.InputError(f"{arguments.hole} is black everywhere; it is white where {path} is to be filled")
        return hole
    hole = np.zeros(image.shape[:2], bool)
    if "A" in kind.channels:
        hole = io.to_pixels(image)[kind.channels.index("A")].numpy() <= TRANSPARENT
    if not hole.any() and arguments.extend is None:
        raise synth.InputError(f"{path} has nothing to fill: give a --hole, --extend it, or make a part transparent")
    return hole


def _extended(image: "Array", hole: "Array", margins: tuple[int, int, int, int] | None) -> "tuple[Array, Array]":
    """The image (H, W, C) and its hole (H, W) with margins (left, top, right, bottom), which are to be filled."""
    import numpy as np

    if margins is None:
        return image, hole
    left, top, right, bottom = margins
    check_size((hole.shape[0] + top + bottom, hole.shape[1] + left + right))
    around = ((top, bottom), (left, right))
    return np.pad(image, (*around, (0, 0)), mode="edge"), np.pad(hole, around, constant_values=True)


def _maps(arguments: argparse.Namespace, output: Path, kind: "Kind", images: "list[Array]") -> "list[Map]":
    """The maps to be filled likewise; and all outputs are checked."""
    sizes = [(image.shape[0], image.shape[1]) for image in images]
    maps = [texture.read_map(request, sizes, output) for request in arguments.also]
    for path, its in [(output, kind), *((carried.output, carried.kind) for carried in maps)]:
        io.check_output(path, its, arguments.overwrite)
    if arguments.map is not None:
        texture.check_source_output(arguments.map, sizes, arguments.overwrite)
    more = [] if arguments.map is None else [arguments.map]
    check_distinct([output, *(carried.output for carried in maps), *more])
    return maps


def _source(source: "Array", hole: "Array", arguments: argparse.Namespace) -> "Array":
    """Where pixels come from in the files: 0 is the image, without its margins, from 1 on are the exemplars."""
    import numpy as np

    left, top = (0, 0) if arguments.extend is None else arguments.extend[:2]
    moved = np.indices((1, *hole.shape))[:, 0] - np.array([0, top, left])[:, None, None]
    if arguments.exemplar:
        return np.where(hole, source + np.array([1, 0, 0])[:, None, None], moved)
    return np.where(hole, source - np.array([0, top, left])[:, None, None], moved)


def _exemplar(path: Path, image: Path, kind: "Kind") -> "Array":
    array, own = io.read_array(path)
    if (own.dtype, own.channels) != (kind.dtype, kind.channels):
        raise synth.InputError(f"{path} holds {own} but {image} holds {kind}; save the exemplar like the image")
    return array
