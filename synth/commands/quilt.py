"""`kwatra quilt`: a new image or video sewn from patches of an exemplar."""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, quilting, texture
from synth.commands.checks import check_distinct, check_size, finish, refuse_unused, set_up
from synth.commands.naming import output_of
from synth.commands.parsing import (
    Parser,
    Subparsers,
    add_common,
    add_scale,
    add_tile,
    file,
    frame_count,
    number,
    numbers,
    positive,
    rate,
    size,
    whole,
)
from synth.commands.progress import work_line
from synth.commands.sewing import add_blending, extra_writers, seams_kind, settings_of, sewn
from synth.commands.telling import about, contributions
from synth.commands.tiles import tile_size
from synth.words import counted, listed

if TYPE_CHECKING:
    from synth.quilting import QuiltSettings

LOADS = ("synth.quilting.video", "synth.texture.maps", "synth.quilting.draw", "synth.io.images", "synth.io.videos")

_EPILOG = """examples:
  kwatra quilt bricks.png                                 twice the size, as bricks_quilt.png
  kwatra quilt pebbles.png --placement sub --tile
  kwatra quilt fountain.mp4 --loop                        an endless loop by one seam in time
  kwatra quilt fire/ -o fire.mp4 --mode time --frames 300
  kwatra quilt river.mp4 --mode spacetime --size 400x300 --loop
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "quilt",
        help="a new image or video sewn from patches of an exemplar",
        description="Graph-cut quilting: patches of the exemplar laid over each other along the best seams.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("exemplars", nargs="+", type=file, metavar="EXEMPLAR", help="an image or several of one texture; a video "
        "(.mp4, .gif, .webm, .mov, .mkv, .avi and others); or a folder of frames")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="the file or folder to write (default: EXEMPLAR_quilt)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: an image's doubled, a video's own)")
    add("--placement", choices=("random", "whole", "sub"), help="how patches are placed: whole for structured "
        "textures, sub for stochastic ones and motion (default: whole; videos: by mode)")  # fmt: skip
    add("--k", type=number(0.001, 1), metavar="K", help="randomness of the choice of offsets, 0.001 to 1 "
        "(default: 0.01)")  # fmt: skip
    add("--refine", type=whole(0, 10**6), metavar="STEPS", help="at most so many patches that mend seams (default: 60)")
    add("--seconds", type=positive, metavar="S", help="stop refining after this time")
    add("--edges", action=argparse.BooleanOptionalAction, help="let seams prefer busy places: normalize their cost by "
        "the gradient (default: for videos only)")  # fmt: skip
    add_tile(parser)
    _add_variants(parser)
    add_blending(parser, "default: 0, and 1 for videos")
    _add_video(parser)
    add("--seams", type=file, metavar="FILE", help="also write the result with its seams drawn in red")
    add("--map", type=file, metavar="FILE", help="also write where each pixel is from: .npy, int32, (exemplar, y, x); "
        "of a video (variant, t, y, x)")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="images: carry a map of the exemplar along, "
        "exactly, to OUT_NAME; with several exemplars NAME=FILE1,FILE2; may be given again")  # fmt: skip
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another result (default: 0)")
    add_common(parser, device=False, verbose=True)


def _add_variants(parser: Parser) -> None:
    """What else than the exemplar itself is copied from."""
    add = parser.add_argument
    add("--rotate", type=numbers, nargs="?", const=(90.0, 180.0, 270.0), metavar="DEG,...", help="use rotated variants "
        "too (without angles, as the last argument: by quarter turns; --rotate=-20,20)")  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored variants too")
    add_scale(parser)
    add("--perspective", action="store_true", help="use only scaled variants: the first scale at the top, the last at "
        "the bottom")  # fmt: skip


def _add_video(parser: Parser) -> None:
    """What only videos have."""
    add = parser.add_argument
    add("--mode", choices=("transition", "time", "spacetime"), help="videos: join the clip to itself, displace it in "
        "time, or in space and time (default: transition; spacetime where --size differs)")  # fmt: skip
    add("--frames", type=frame_count(2), metavar="N", help="videos: length (default: one loop, or twice the clip)")
    add("--loop", action="store_true", help="videos: make the end meet the beginning")
    add("--hold", type=whole(1), metavar="K", help="videos: frames that a loop holds at its ends (default: 10, or half "
        "a short clip)")  # fmt: skip
    add("--fps", type=rate, metavar="F", help="videos: frames a second (default: as the file says; a folder: 25)")


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    if arguments.perspective and (len(arguments.scale or ()) < 2 or arguments.tile):
        raise synth.InputError("--perspective needs a range of scales and no tile; give --scale A:B without --tile")
    video = next((path for path in arguments.exemplars if io.is_video(path)), None)
    if video is not None and len(arguments.exemplars) > 1:
        raise synth.InputError(f"{video} is a video, of which only one is quilted; give images, or one video")
    return (_image if video is None else _video)(arguments)


def _image(arguments: argparse.Namespace) -> str:
    sources, source = arguments.exemplars, arguments.exemplars[0]
    refuse_unused(arguments, ("mode", "frames", "loop", "hold", "fps"), f"is for videos but {source} is an image")
    settings = settings_of(quilting.QuiltSettings(), arguments)
    _refuse_k(arguments, settings)
    exemplars, kind = io.raised([io.read_image(path) for path in sources], sources)
    exemplars = [io.premultiplied(exemplar, kind) for exemplar in exemplars]
    height, width = arguments.size or [2 * n for n in exemplars[0].shape[1:]]
    check_size((height, width))
    height, width = tile_size(arguments.tile, (height, width), exemplars)
    output = output_of(arguments.output, f"{source.stem}_quilt{source.suffix}")
    sizes = [(exemplar.shape[1], exemplar.shape[2]) for exemplar in exemplars]
    maps = [texture.read_map(request, sizes, output) for request in arguments.also]
    _check_outputs(arguments, output, [carried.output for carried in maps])
    for path, its in [(output, kind), *((carried.output, carried.kind) for carried in maps)]:
        io.check_output(path, its, arguments.overwrite)
    if arguments.seams is not None:
        io.check_output(arguments.seams, seams_kind(), arguments.overwrite)
    began = time.perf_counter()
    with work_line(f"{source.name} to {width}x{height}") as report:
        result = quilting.quilt(exemplars, (height, width), settings, report)
    took = time.perf_counter() - began
    origins = quilting.origins(result, exemplars, settings)
    turns = quilting.turns(result, exemplars, settings)
    image = io.straight(result.image, kind)
    writers = {output: io.image_writer(output, image, kind)} | extra_writers(arguments, result)
    if arguments.map is not None:
        writers[arguments.map] = texture.source_writer(arguments.map, origins, turns)
    writers |= {carried.output: texture.map_writer(carried, origins, turns) for carried in maps}
    finish(writers, arguments.overwrite)
    told = about(result.image, exemplars) + contributions(sources, origins[0])
    more = sewn(result, output, kind) if arguments.verbose else ""
    return f"wrote {listed(list(writers))}: {width}x{height}, seed {arguments.seed}, in {took:.1f} s{told}{more}"


def _video(arguments: argparse.Namespace) -> str:
    source = arguments.exemplars[0]
    refuse_unused(arguments, ["also"], f"is for images but {source} is a video")
    output = arguments.output or Path(f"{source.stem}_quilt{io.written_like(source)}")
    _check_outputs(arguments, output)
    io.check_video_output(output, arguments.overwrite)
    if arguments.seams is not None:
        io.check_video_output(arguments.seams, arguments.overwrite)
    if output.suffix.lower() not in io.VIDEO_SUFFIXES:
        refuse_unused(arguments, ["fps"], f"is for video files but {output} is to be a folder of frames")
    clip = io.read_video(source, arguments.fps or 25.0)
    count, size = clip.frames.shape[1], arguments.size or tuple(clip.frames.shape[-2:])
    larger = size != tuple(clip.frames.shape[-2:])
    mode = arguments.mode or ("spacetime" if larger else "transition")
    settings = settings_of(quilting.default_settings(mode), arguments)
    _check_video(arguments, mode, larger, settings)
    check_size(size, arguments.frames or 2 * count)
    began = time.perf_counter()
    with work_line(f"{source.name}, {mode}") as report:
        result = quilting.quilt_video(
            io.premultiplied(clip.frames, clip.kind),
            arguments.frames,
            size,
            mode=mode,
            loop=arguments.loop,
            hold=arguments.hold,
            settings=settings,
            report=report,
        )
    took = time.perf_counter() - began
    fps, extremes = arguments.fps or clip.rate, io.extremes_of(clip.kind, [clip.frames])
    frames = io.straight(result.image, clip.kind).unbind(1)
    writers = {output: io.video_writer(output, frames, fps, clip.kind, extremes)}
    writers |= extra_writers(arguments, result, fps)
    finish(writers, arguments.overwrite)
    made, height, width = result.patch.shape
    more = sewn(result, output, clip.kind) if arguments.verbose else ""
    size_of_all = f"{counted(made, 'frame')} of {width}x{height}"
    return f"wrote {listed(list(writers))}: {size_of_all}, seed {arguments.seed}, in {took:.1f} s{more}"


def _check_video(arguments: argparse.Namespace, mode: str, larger: bool, settings: "QuiltSettings") -> None:
    """Refuse what this way to a video would ignore."""
    if mode == "transition":
        unused = ("placement", "k", "refine", "seconds", "tile", "rotate", "mirror", "scale", "perspective", "hold")
        refuse_unused(arguments, unused, "is for --mode time and spacetime but a transition sews no patches")
    if not arguments.loop or (larger and arguments.frames is None):
        refuse_unused(
            arguments, ["hold"], "is for a --loop in --mode time or spacetime, of --frames where --size differs"
        )
    _refuse_k(arguments, settings)


def _refuse_k(arguments: argparse.Namespace, settings: "QuiltSettings") -> None:
    if settings.placement == "random":
        refuse_unused(arguments, ["k"], "is for --placement whole and sub but it is random")


def _check_outputs(arguments: argparse.Namespace, output: Path, more: Sequence[Path] = ()) -> None:
    if arguments.map is not None:
        io.check_output(arguments.map, None, arguments.overwrite, (".npy",))
    check_distinct([path for path in (output, arguments.seams, arguments.map, *more) if path is not None])
