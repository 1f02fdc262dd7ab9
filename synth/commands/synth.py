"""`kwatra synth`: a new image from one or more exemplars of a texture."""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import check_distinct, check_size, finish, refuse_unused, set_up
from synth.commands.parsing import Subparsers, add_common, file, levels, numbers, positive, size, whole
from synth.commands.progress import progress_line
from synth.commands.report import ENERGY_SUFFIXES, energy_writer
from synth.words import listed

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Array, Kind, Picture, Writer
    from synth.texture import Map, Synthesis

LOADS = ("synth.texture.images", "synth.texture.maps")

_EPILOG = """examples:
  kwatra synth brick.png                               twice the size, as brick_synth.png
  kwatra synth brick.png -o wall.png --size 1024x768 --tile
  kwatra synth brick.png --also normal=brick_n.png     also writes brick_synth_normal.png
  kwatra synth field.png --guide field_labels.png=wanted_labels.png
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "synth",
        help="a new image from one or more exemplars of a texture",
        description="Make a new image that looks like the exemplars. PNG, JPEG, TIFF and EXR come out\n"
        "as they went in: gray or color, alpha, 8 or 16 bits or float.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("exemplars", nargs="+", type=file, metavar="EXEMPLAR", help="image of the texture, or several of it")
    add("-o", "--output", type=file, metavar="OUT", help="the file to write (default: EXEMPLAR_synth in this folder)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels, as 512x384 (default: twice the exemplar)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another image (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add("--tile", action="store_true", help="make an image that repeats without a seam in both directions")
    add("--start", type=file, metavar="IMAGE", help="image to start from, of the size to make")
    add("--levels", type=levels, metavar="SCALE:WIDTH,...", help='"4:32,2:16,1:8": windows 32 wide at 1/4 size, and '
        'so on; or "thesis", the levels of Kwatra\'s thesis (default: planned from the exemplar)')  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored copies of the exemplars too")
    add("--rotate", type=numbers, default=(), metavar="DEG,...", help="use rotated copies too (--rotate=-90,90)")
    add("--scale", type=numbers, default=(), metavar="FACTOR,...", help="use scaled copies too")
    add("--progress-images", type=file, metavar="DIR", help="write the image after each level into this folder")
    add("--energy", type=file, metavar="FILE", help="write the energy per iteration as .csv or drawn as .png")
    add("--map", type=file, metavar="FILE", help="write where each pixel comes from: .npy int32 (exemplar, y, x) by "
        "(3, H, W), or 16-bit .png with R = x, G = y, B = exemplar")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="carry a map of the exemplar along, exactly, "
        "to OUT_NAME; with several exemplars NAME=FILE1,FILE2; may be given again")  # fmt: skip
    add("--guide", metavar="MAP=MAP", help="EXEMPLAR_MAP=OUTPUT_MAP: put texture where the output's map is like the "
        "exemplar's (labels, a density, a direction); with several exemplars A,B=OUTPUT_MAP")  # fmt: skip
    add("--guide-weight", type=positive, metavar="W", help="what the guide counts beside the colors; "
        "0.1 to 0.3 suits maps that vary smoothly (default: 1)")  # fmt: skip
    add_common(parser)


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    exemplars = [io.read_image(path) for path in arguments.exemplars]
    _check_alike(arguments.exemplars, exemplars)
    start = None if arguments.start is None else _read_start(arguments.start, exemplars[0], arguments.size)
    if arguments.guide is None:
        refuse_unused(arguments, ["guide_weight"], "says what a --guide counts but there is none")
    guide = None if arguments.guide is None else texture.read_guide(arguments.guide, len(exemplars))
    height, width = _output_size(arguments.size, exemplars[0], start, guide)
    first = arguments.exemplars[0]
    output = arguments.output or Path(f"{first.stem}_synth{first.suffix}")
    sizes = [_size_of(exemplar) for exemplar in exemplars]
    maps = [texture.read_map(request, sizes, output) for request in arguments.also]
    _check_outputs(arguments, output, maps, exemplars)
    began = time.perf_counter()
    with progress_line(f"{first.name} to {width}x{height}") as callback:
        synthesis = texture.synthesize(
            [io.premultiplied(exemplar.pixels, exemplar.kind) for exemplar in exemplars],
            (height, width),
            preset=arguments.preset,
            seed=arguments.seed,
            tile=arguments.tile,
            start=None if start is None else io.premultiplied(start.pixels, start.kind),
            levels=arguments.levels,
            mirror=arguments.mirror,
            rotate=arguments.rotate,
            scale=arguments.scale,
            guide=guide,
            guide_weight=arguments.guide_weight or 1.0,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    writers = _writers(arguments, output, maps, synthesis, exemplars[0].kind)
    finish(writers)
    return f"wrote {listed(list(writers))}: {width}x{height} in {took:.1f} s ({synthesis.result.stopped})"


def _writers(
    arguments: argparse.Namespace, output: Path, maps: "Sequence[Map]", synthesis: "Synthesis[Tensor]", kind: "Kind"
) -> "dict[Path, Writer]":
    writers = {output: io.image_writer(output, io.straight(synthesis.image, kind), kind)}
    writers |= {carried.output: texture.map_writer(carried, synthesis) for carried in maps}
    if arguments.map is not None:
        writers[arguments.map] = texture.source_writer(arguments.map, synthesis.source)
    if arguments.energy is not None:
        writers[arguments.energy] = energy_writer(arguments.energy, synthesis.result.energies)
    if arguments.progress_images is not None:
        writers |= _stage_writers(arguments.progress_images, synthesis, kind, output.suffix)
    return writers


def _check_alike(paths: Sequence[Path], exemplars: "Sequence[Picture]") -> None:
    """Several exemplars of one texture must mean the same by their channels and values."""
    first = exemplars[0].kind
    for path, exemplar in zip(paths, exemplars, strict=True):
        kind = exemplar.kind
        if len(kind.channels) != len(first.channels) or kind.dtype.startswith("f") != first.dtype.startswith("f"):
            raise synth.InputError(
                f"{path} holds {kind} but {paths[0]} holds {first}; save all exemplars in the same way"
            )


def _read_start(path: Path, exemplar: "Picture", size: tuple[int, int] | None) -> "Picture":
    start = io.read_image(path)
    if len(start.pixels) != len(exemplar.pixels):
        raise synth.InputError(f"{path} holds {start.kind} but the exemplar {exemplar.kind}; save it like the exemplar")
    if size is not None and size != _size_of(start):
        height, width = _size_of(start)
        raise synth.InputError(f"{path} is {width}x{height} but --size asks for {size[1]}x{size[0]}; leave --size out")
    return start


def _output_size(
    asked: tuple[int, int] | None,
    exemplar: "Picture",
    start: "Picture | None",
    guide: "tuple[list[Array], Array] | None",
) -> tuple[int, int]:
    """(height, width): as asked, or the start's or the guide's, or twice the exemplar's."""
    twice = [2 * side for side in _size_of(exemplar)]
    guided = None if guide is None else guide[1].shape[:2]
    height, width = asked or (_size_of(start) if start is not None else guided or twice)
    if guided is not None and guided != (height, width):
        raise synth.InputError(
            f"the guide's output map is {guided[1]}x{guided[0]} but the output {width}x{height}; give both one size"
        )
    check_size((height, width))
    return height, width


def _size_of(picture: "Picture") -> tuple[int, int]:
    return picture.pixels.shape[1], picture.pixels.shape[2]


def _check_outputs(
    arguments: argparse.Namespace, output: Path, maps: "Sequence[Map]", exemplars: "Sequence[Picture]"
) -> None:
    """Refuse before any work what could not be written after it."""
    overwrite, files = arguments.overwrite, [output, *(carried.output for carried in maps)]
    io.check_output(output, exemplars[0].kind, overwrite)
    for carried in maps:
        io.check_output(carried.output, carried.kind, overwrite)
    if arguments.map is not None:
        texture.check_source_output(arguments.map, [_size_of(exemplar) for exemplar in exemplars], overwrite)
    if arguments.energy is not None:
        io.check_output(arguments.energy, None, overwrite, ENERGY_SUFFIXES)
    if arguments.progress_images is not None:
        _check_folder(arguments.progress_images, overwrite)
    extra = [arguments.map, arguments.energy, arguments.progress_images]
    check_distinct([*files, *(path for path in extra if path is not None)])


def _check_folder(folder: Path, overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise synth.InputError(f"{folder} is a file; name a folder for the progress images")
    if not folder.exists() and not folder.parent.is_dir():
        raise synth.InputError(f"{folder} cannot be made because {folder.parent} does not exist; make that first")
    if folder.exists() and any(folder.glob("level_*")) and not overwrite:
        raise synth.InputError(
            f"{folder} already holds progress images; name another folder or allow it with --overwrite"
        )


def _stage_writers(folder: Path, synthesis: "Synthesis[Tensor]", kind: "Kind", suffix: str) -> "dict[Path, Writer]":
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise synth.InputError(f"{folder} cannot be made ({error.strerror}); choose another") from error
    writers = {}
    for number, (stage, image) in enumerate(zip(synthesis.result.stages, synthesis.stages, strict=True), 1):
        path = folder / f"level_{number}_scale{stage.factor}_width{stage.width}{suffix}"
        writers[path] = io.image_writer(path, io.straight(image, kind), kind)
    return writers
