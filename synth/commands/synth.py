"""`kwatra synth`: a new image from one or more exemplars of a texture, or a new video from videos."""

import argparse
import time
from typing import TYPE_CHECKING

from synth import io, texture
from synth.commands.checks import finish, refuse_unused, set_up
from synth.commands.guides import add_guides, guide_weights
from synth.commands.naming import for_each
from synth.commands.parsing import (
    Parser,
    Subparsers,
    add_common,
    add_scale,
    add_tile,
    file,
    frame_count,
    levels,
    number,
    numbers,
    positive,
    rate,
    size,
    whole,
)
from synth.commands.progress import progress_line
from synth.commands.synth_inputs import Inputs
from synth.commands.synth_outputs import check_outputs, writers_of
from synth.commands.telling import about, contributions, details, of_result, quality
from synth.commands.tiles import tile_size
from synth.commands.wishes import add_wishes
from synth.words import listed

if TYPE_CHECKING:
    from torch import Tensor

    from synth.texture import Synthesis

LOADS = ("synth.texture.images", "synth.texture.maps")

_EPILOG = """examples:
  kwatra synth brick.png                               twice the size, as brick_synth.png
  kwatra synth brick.png -o wall.png --size 1024x768 --tile
  kwatra synth brick.png --also normal=brick_n.png     also writes brick_synth_normal.png
  kwatra synth a.png b.png c.png --each -o made/       three textures; without --each one that blends all three
  kwatra synth brick.png --map where.npy               and when its other maps are there:
  kwatra synth brick_n.png --apply where.npy           a map, rearranged as brick.png was
  kwatra synth sand.png --keep logo.png                a new texture around the logo's opaque pixels
  kwatra synth fountain.mp4 --seconds 20 --loop        a video of the same size that loops
  kwatra synth field.png --guide field_labels.png=wanted_labels.png
  kwatra synth brick.png grass.png --guide labels=wanted.png   bricks where it is dark, grass where it is light
  kwatra synth grass.png --guide tones=drawing.png     as light and dark as a drawing of its size
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "synth",
        help="a new image from one or more exemplars of a texture",
        description="Make a new image that looks like the exemplars. PNG, JPEG, TIFF, EXR, WebP, BMP\n"
        "and TGA come out as they went in: gray or color, alpha, 8 or 16 bits or float.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("exemplars", nargs="+", type=file, metavar="EXEMPLAR", help="image of the texture, or several of it; or a "
        "video (.mp4, .gif, .webm, .mov, .mkv, .avi and others) or a folder of frames, or several")  # fmt: skip
    add("-o", "--output", type=file, metavar="OUT", help="the file to write, or the folder it goes to (default: "
        "EXEMPLAR_synth in this folder)")  # fmt: skip
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels, as 512x384 (default: twice the exemplar, or "
        "a video's own)")  # fmt: skip
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another image (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_tile(parser)
    add("--start", type=file, metavar="IMAGE", help="image to start from, of the size to make")
    add("--levels", type=levels, metavar="SCALE:WIDTH,...", help='"4:32,2:16,1:8": windows 32 wide at 1/4 size, and '
        'so on; or "thesis", the levels of Kwatra\'s thesis (default: planned from the exemplar)')  # fmt: skip
    add("--mirror", action="store_true", help="use mirrored variants of the exemplars too")
    add("--rotate", type=numbers, default=(), metavar="DEG,...", help="use rotated variants too (--rotate=-90,90)")
    add_scale(parser)
    add("--progress-images", type=file, metavar="DIR", help="write the image after each level into this folder")
    add("--energy", type=file, metavar="FILE", help="write the energy per iteration as .csv or drawn as .png")
    add("--map", type=file, metavar="FILE", help="write where each pixel comes from: .npy int32 (exemplar, y, x) by "
        "(3, H, W), a fourth row where they are turned; or 16-bit .png with R = x, G = y, B = exemplar")  # fmt: skip
    add("--also", action="append", default=[], metavar="NAME=FILE", help="carry a map of the exemplar along, exactly, "
        "to OUT_NAME; with several exemplars NAME=FILE1,FILE2; may be given again")  # fmt: skip
    add_guides(parser)
    add("--stay", type=number(0, 1e6), metavar="W", help="how strongly what belongs somewhere stays there: "
        "0 not at all, 1 strongly (default: 0; videos: 0.3 where what is seen depends on the place)")  # fmt: skip
    add_video(parser)
    add("--each", action="store_true", help="make one output of each exemplar instead of one of all; -o may name a "
        "folder for them")  # fmt: skip
    add("--apply", type=file, metavar="MAP", help="synthesize nothing: rearrange the EXEMPLAR as a MAP says that --map "
        "has written, of synth, quilt, tile or fill; for maps that come later")  # fmt: skip
    add_wishes(parser)
    add_common(parser, verbose=True)


def add_video(parser: argparse.ArgumentParser) -> None:
    """Add what only videos have."""
    add = parser.add_argument
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--frames", type=frame_count(1), metavar="N", help="videos: length (default: twice the clip's)")
    length.add_argument("--seconds", type=positive, metavar="S", help="videos: length in seconds")
    add("--loop", action="store_true", help="videos: the last frame leads into the first")
    add("--fps", type=rate, metavar="F", help="videos: frames a second (default: as the file says; a folder: 25)")
    add("--resume", action="store_true", help="videos: go on after the last frame of an interrupted run")


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    set_up(arguments)
    if any(map(io.is_video, arguments.exemplars)):
        from synth.commands.synth_video import run_video

        return run_video(arguments)
    video = ("frames", "seconds", "loop", "fps", "resume")
    refuse_unused(arguments, video, f"is for videos but {arguments.exemplars[0]} is an image")
    if arguments.apply is not None:
        from synth.commands.applying import apply

        return apply(arguments, _defaults())
    if not arguments.each:
        return _one(arguments, True)
    single = ("also", "map", "energy", "progress_images")
    refuse_unused(arguments, single, "belongs to one output but --each makes several")
    return for_each(arguments, _one)


def _defaults() -> argparse.Namespace:
    """The arguments as they are where only an exemplar is given."""
    parser = Parser()
    add(parser.add_subparsers(dest="command"))
    return parser.parse_args(["synth", "EXEMPLAR"])


def _one(arguments: argparse.Namespace, work: bool) -> str:
    """One output, or only the checks before it; returns the summary."""
    inputs = Inputs.read(arguments)
    check_outputs(arguments, inputs)
    if not work:
        return ""
    height, width = tile_size(arguments.tile, inputs.size, inputs.exemplars)
    exemplars, start = [io.premultiplied(exemplar, inputs.kind) for exemplar in inputs.exemplars], inputs.start
    began = time.perf_counter()
    with progress_line(f"{arguments.exemplars[0].name} to {width}x{height}") as callback:
        synthesis = texture.synthesize(
            exemplars,
            (height, width),
            preset=arguments.preset,
            seed=arguments.seed,
            tile=arguments.tile is not None,
            stay=arguments.stay or 0.0,
            start=None if start is None else io.premultiplied(start.pixels, start.kind),
            levels=arguments.levels,
            mirror=arguments.mirror,
            rotate=arguments.rotate,
            scale=arguments.scale or (),
            terms=inputs.wishes.terms(exemplars, arguments.device),
            mask=inputs.wishes.mask,
            guide=inputs.guides or None,
            guide_weight=guide_weights(arguments),
            exemplar_mask=inputs.wishes.allowed,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    writers = writers_of(arguments, inputs, synthesis)
    finish(writers, arguments.overwrite, more=getattr(arguments, "more", False))
    told = contributions(arguments.exemplars, synthesis.source[0])
    told += "; its light, which falls unevenly, was evened" if synthesis.even else ""
    exemplars = [*synthesis.even] or exemplars
    more = _details(arguments, inputs, synthesis, exemplars) if arguments.verbose else ""
    alike = inputs.wishes.mask is None and not inputs.guides  # else it is not to be like the exemplars all over
    good = about(synthesis.image, exemplars) if alike and not more else ""
    return f"wrote {listed(list(writers))}: {width}x{height}, seed {arguments.seed}, in {took:.1f} s{good}{told}{more}"


def _details(
    arguments: argparse.Namespace, inputs: Inputs, synthesis: "Synthesis[Tensor]", exemplars: "list[Tensor]"
) -> str:
    rows = {"file": inputs.output.resolve(), "pixels": inputs.kind, "preset": arguments.preset}
    return details({**rows, **of_result(synthesis.result), **quality(synthesis.image, exemplars)})
