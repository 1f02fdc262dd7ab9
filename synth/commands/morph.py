"""`kwatra morph`: a film, a folder of frames, a contact sheet or one frame from one texture to another."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import check_distinct, check_size, finish, set_up
from synth.commands.morph_between import (
    MASK,
    check_features,
    features_writers,
    is_between,
    is_image,
    is_video,
    run_between,
)
from synth.commands.morph_folder import Folder
from synth.commands.morph_options import add_method_options, in_order, method_options
from synth.commands.parsing import Subparsers, add_common, file, frame_count, numbers, rate, size, whole
from synth.words import counted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from torch import Tensor

    from synth.io import Kind, Writer
    from synth.metamorphosis.door import Metamorphosis

LOADS = ("synth.metamorphosis.door", "synth.io.images")

_FRAMES = 11
_FLOWS = (".npz", ".npy")
_EPILOG = """examples:
  kwatra morph brick.png stone.png                     11 frames in one picture, as brick_stone.png
  kwatra morph brick.png stone.png -o film.mp4 --frames 48 --there-and-back
  kwatra morph brick.png stone.png -o half.png --at 0.5 --retexture
  kwatra morph brick.png stone.png --map fade.png      each pixel its own time
  kwatra morph brick.png stone.png moss.png --at 1,1,2 -o half_moss.png
  kwatra morph leaf.png moss.png --features leaf_veins.png moss_tufts.png --flow way.npz -o frames/
"""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "morph",
        help="a metamorphosis from one texture to another",
        description="Lead from texture A to texture B over frames that are textures themselves.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("a", type=file, metavar="A", help="image of the texture to begin with")
    add("b", type=file, metavar="B", help="image of the texture to end with")
    add("more", type=file, nargs="*", default=[], metavar="C", help="further textures, with --at W,W,... or --weights")
    add("-o", "--output", type=file, metavar="OUT", help="an .mp4, .gif, .webm or .mov; a folder for the frames as "
        "they are; or an image for all frames in one (default: A_B.png in this folder)")  # fmt: skip
    add("--method", metavar="NAME", help="patches (the default), control, registration, blend, patterns or textons")
    length = parser.add_mutually_exclusive_group().add_argument
    length("--frames", type=frame_count(1), metavar="N", help=f"how many, A and B included (default: {_FRAMES})")
    length("--at", type=_moment, metavar="T", help="one frame only, at this time from 0 (A) to 1 (B); or "
        "W,W,...: the weight of each texture")  # fmt: skip
    add("--map", type=file, metavar="FILE", help="an image, black where A belongs and white where B does; or a video "
        "or folder of such, which makes a film")  # fmt: skip
    add("--weights", type=file, metavar="FILE", help="an image, or a video or folder, with a channel for each texture: "
        "its weight there")  # fmt: skip
    add("--there-and-back", action="store_true", help="and back to A, so that the film can run in a loop")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="synthesize A at this size, B with its features where A's "
        "lie, and morph these (default: what A and B have in common)")  # fmt: skip
    add("--features", type=file, nargs="+", metavar="MASK", help="for each texture an image of its size, white where "
        "what is to move onto each other lies")  # fmt: skip
    add("--tile", action="store_true", help="A and B repeat seamlessly, and so do the frames")
    add("--retexture", action="store_true", help="make what the method shows texture again, frame by frame")
    add("--energy", type=file, metavar="FILE", help="write the energy per iteration as .csv or drawn as .png")
    add("--flow", type=file, metavar="FILE", help="write the velocity, one flow per time step, as .npz or .npy")
    add("--fps", type=rate, default=25.0, metavar="F", help="frames a second of a video (default: 25)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another texture (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_common(parser)
    add_method_options(parser)


def run(arguments: argparse.Namespace) -> str:
    """The summary."""
    from synth.commands.progress import work_line
    from synth.metamorphosis.door import begun
    from synth.metamorphosis.methods import DEFAULT

    if is_between(arguments):
        return run_between(arguments)
    set_up(arguments)
    paths = [arguments.a, arguments.b]
    pictures, kind = io.raised([io.read_image(path) for path in paths], paths)
    pictures = [io.premultiplied(picture, kind) for picture in pictures]
    output = arguments.output or Path(f"{arguments.a.stem}_{arguments.b.stem}.png")
    _check(arguments, output, kind)
    options = method_options(arguments, arguments.method or DEFAULT, pictures)
    features = arguments.features
    masks = None if features is None else (io.read_mask(features[0]), io.read_mask(features[1]))
    began = time.perf_counter()
    with work_line(f"{arguments.a.name} to {arguments.b.name}") as report:
        made = begun(
            pictures[0],
            pictures[1],
            [arguments.at] if arguments.at is not None else arguments.frames or _FRAMES,
            method=arguments.method or DEFAULT,
            size=arguments.size,
            features=masks,
            tile=arguments.tile,
            retexture=arguments.retexture,
            preset=arguments.preset,
            seed=arguments.seed,
            device=arguments.device,
            callback=report,
            **options,
        )
        order = in_order(len(made.frames), arguments.there_and_back)
        folder = Folder(output, len(order))
        shown = (io.straight(made.frames[number], kind) for number in order)
        finish(_writers(arguments, folder, kind, made, shown), arguments.overwrite)
        folder.tell()
    took = time.perf_counter() - began
    height, width = made.frames[0].shape[1:]
    told = "".join(f"\n{remark}" for remark in made.remarks)
    return f"wrote {output}: {counted(len(order), 'frame')} of {width}x{height} in {took:.1f} s{told}"


def _moment(text: str) -> float | tuple[float, ...]:
    """A time from 0 to 1, or weights."""
    if "," in text:
        return numbers(text)
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no time from 0 (A) to 1 (B)")
    return value


def _check(arguments: argparse.Namespace, output: Path, kind: "Kind") -> None:
    """Refuse before any work what could not be written after it."""
    from synth.commands.report import ENERGY_SUFFIXES
    from synth.metamorphosis.methods import DEFAULT, refuse_unused

    if arguments.size is not None:
        check_size(arguments.size)
    if arguments.features is not None and len(arguments.features) != 2:
        raise synth.InputError(f"--features names {counted(len(arguments.features), 'file')}; name A's and B's")
    if arguments.at is not None and (arguments.there_and_back or not is_image(output)):
        raise synth.InputError("--at makes one frame; name an image for it with -o, and leave --there-and-back out")
    if arguments.at is not None and arguments.median is not None:
        raise synth.InputError("--median is over several frames and --at makes one; leave one of them out")
    if is_image(output):
        io.check_output(output, kind, arguments.overwrite)
    else:
        io.check_video_output(output, arguments.overwrite)
    method = arguments.method or DEFAULT
    refuse_unused(method, "energies", arguments.energy is not None)
    refuse_unused(method, "moves", arguments.flow is not None)
    refuse_unused(method, "masks", arguments.show_masks is not None)
    for path in arguments.show_masks or ():
        io.check_output(path, synth.Kind(*MASK), arguments.overwrite)
    if arguments.energy is not None:
        io.check_output(arguments.energy, None, arguments.overwrite, ENERGY_SUFFIXES)
    if arguments.flow is not None:
        if arguments.flow.suffix.lower() not in _FLOWS:
            raise synth.InputError(f"{arguments.flow} cannot hold a flow in time; end it with {' or '.join(_FLOWS)}")
        io.check_flow_output(arguments.flow, arguments.overwrite)
    refuse_unused(method, "finds", arguments.show_features is not None)
    check_features(arguments.show_features, 2, arguments.overwrite)
    more = (arguments.energy, arguments.flow, *(arguments.show_masks or ()), *(arguments.show_features or ()))
    check_distinct([output, *(path for path in more if path is not None)])


def _writers(
    arguments: argparse.Namespace,
    folder: Folder,
    kind: "Kind",
    made: "Metamorphosis[Tensor]",
    frames: "Iterator[Tensor]",
) -> "dict[Path, Writer]":
    """What writes each file."""
    from synth.commands.report import energy_writer
    from synth.sheets import contact_sheet

    writers: dict[Path, Writer] = {}
    output = folder.path
    if is_image(output):
        writers[output] = io.image_writer(output, contact_sheet(list(frames)), kind)
    else:
        extremes = (made.form.low, made.form.high) if kind.dtype.startswith("f") else (0.0, 1.0)
        writer = io.video_writer(output, frames, arguments.fps, kind, extremes)
        writers[output] = writer if is_video(output) else folder.keeping(writer)
    if arguments.energy is not None:
        writers[arguments.energy] = energy_writer(arguments.energy, made.film.energies)
    if arguments.flow is not None and made.film.velocity is not None:
        writers[arguments.flow] = io.flow_writer(arguments.flow, made.film.velocity)
    if arguments.show_masks is not None and made.film.masks is not None:
        for path, mask in zip(arguments.show_masks, made.film.masks, strict=True):
            writers[path] = io.image_writer(path, mask[None].float(), synth.Kind(*MASK))
    return writers | features_writers(arguments.show_features, made.film.features or ())
