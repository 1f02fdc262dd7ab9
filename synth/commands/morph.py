"""`kwatra morph`: a film, a folder of frames, a contact sheet or one frame from one texture to another."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.commands.parsing import add_common, rate, size, whole

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io.image_formats import Kind
    from synth.io.images import Picture, Writer
    from synth.morph.door import Metamorphosis

_FRAMES = 11
_FLOWS = (".npz", ".npy")
_VIDEOS = (".mp4", ".gif")
_EPILOG = """examples:
  kwatra morph brick.png stone.png                     11 frames in one picture, as brick_stone.png
  kwatra morph brick.png stone.png -o film.mp4 --frames 48 --there-and-back
  kwatra morph brick.png stone.png -o half.png --at 0.5 --retexture
  kwatra morph leaf.png moss.png --features leaf_veins.png moss_tufts.png --flow way.npz -o frames/
"""


def add_morph(commands: Any) -> None:
    """Add the command to an argparse subparsers object."""
    parser = commands.add_parser(
        "morph",
        help="a metamorphosis from one texture to another",
        description="Lead from texture A to texture B over frames that are textures themselves.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("a", type=Path, metavar="A", help="image of the texture to begin with")
    add("b", type=Path, metavar="B", help="image of the texture to end with")
    add("-o", "--output", type=Path, metavar="OUT", help="an .mp4 or .gif; a folder for the frames as they are; or an "
        "image for all frames in one (default: A_B.png in this folder)")  # fmt: skip
    add("--method", metavar="NAME", help="control (the default), registration or blend; another name lists them all")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--frames", type=whole(1), metavar="N", help=f"how many, A and B included (default: {_FRAMES})")
    length.add_argument("--at", type=_moment, metavar="T", help="one frame only, at this time from 0 (A) to 1 (B)")
    add("--there-and-back", action="store_true", help="and back to A, so that the film can run in a loop")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="synthesize A at this size, B with its features where A's "
        "lie, and morph these (default: what A and B have in common)")  # fmt: skip
    add("--features", type=Path, nargs=2, metavar=("A_MASK", "B_MASK"), help="images of A's and B's size, white where "
        "what is to move onto each other lies")  # fmt: skip
    add("--tile", action="store_true", help="A and B repeat seamlessly, and so do the frames")
    add("--retexture", action="store_true", help="make what the method shows texture again, frame by frame")
    add("--energy", type=Path, metavar="FILE", help="write the energy per iteration as .csv or drawn as .png")
    add("--flow", type=Path, metavar="FILE", help="write the velocity, one flow per time step, as .npz or .npy")
    add("--fps", type=rate, default=25.0, metavar="F", help="frames a second of a video (default: 25)")
    add("--seed", type=whole(0), default=0, metavar="N", help="another seed, another texture (default: 0)")
    add("--preset", choices=("fast", "default", "best"), default="default", help="how much work to spend")
    add_common(parser)


def run_morph(arguments: argparse.Namespace) -> str:
    """`kwatra morph`: returns the summary."""
    from synth.commands.progress import work_line
    from synth.commands.synth import set_up
    from synth.io.images import read_mask, write_files
    from synth.morph.door import morph
    from synth.morph.methods import DEFAULT

    set_up(arguments.device, arguments.threads)
    pictures = [_read(path) for path in (arguments.a, arguments.b)]
    kind = _kind(arguments, pictures)
    output = arguments.output or Path(f"{arguments.a.stem}_{arguments.b.stem}.png")
    _check(arguments, output, kind)
    masks = None if arguments.features is None else (read_mask(arguments.features[0]), read_mask(arguments.features[1]))
    began = time.perf_counter()
    with work_line(f"{arguments.a.name} to {arguments.b.name}") as report:
        made = morph(
            pictures[0].pixels,
            pictures[1].pixels,
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
        )
        frames = made.frames + (made.frames[-2:0:-1] if arguments.there_and_back else [])
        write_files(_writers(arguments, output, kind, made, frames))
    took = time.perf_counter() - began
    height, width = frames[0].shape[1:]
    told = "".join(f"\n{remark}" for remark in made.remarks)
    return f"wrote {output}: {len(frames)} frames of {width}x{height} in {took:.1f} s{told}"


def _moment(text: str) -> float:
    """A time from 0 to 1."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no time from 0 (A) to 1 (B)")
    return value


def _read(path: Path) -> "Picture":
    from synth.io.images import read_image

    return read_image(path)


def _kind(arguments: argparse.Namespace, pictures: "list[Picture]") -> "Kind":
    """How frames are kept: with the channels and the depth of the one of A and B that has more."""
    from dataclasses import replace

    from kwatra.base import InputError

    first, second = (picture.kind for picture in pictures)
    if first.dtype.startswith("f") != second.dtype.startswith("f"):
        raise InputError(f"{arguments.a} holds {first} but {arguments.b} {second}; save both in the same way")
    richer = second if len(second.channels) > len(first.channels) else first
    sizes = {"bool": 1, "uint8": 8, "uint16": 16, "float16": 16, "float32": 32, "float64": 64}
    return replace(richer, dtype=max(first.dtype, second.dtype, key=lambda name: max(sizes[name], 8)))


def _check(arguments: argparse.Namespace, output: Path, kind: "Kind") -> None:
    """Refuse before any work what could not be written after it."""
    from kwatra.base import InputError
    from synth.commands.report import ENERGY_SUFFIXES
    from synth.commands.synth import check_size
    from synth.io.flows import check_flow_output
    from synth.io.images import check_output
    from synth.io.videos import check_video_output
    from synth.morph.methods import DEFAULT, refuse_unused

    if arguments.size is not None:
        check_size(arguments.size)
    if arguments.at is not None and (arguments.there_and_back or not _is_image(output)):
        raise InputError("--at makes one frame; name an image for it with -o, and leave --there-and-back out")
    if _is_image(output):
        check_output(output, kind, arguments.overwrite)
    else:
        check_video_output(output, arguments.overwrite)
    method = arguments.method or DEFAULT
    refuse_unused(method, "energies", arguments.energy is not None)
    refuse_unused(method, "moves", arguments.flow is not None)
    if arguments.energy is not None:
        check_output(arguments.energy, None, arguments.overwrite, ENERGY_SUFFIXES)
    if arguments.flow is not None:
        if arguments.flow.suffix.lower() not in _FLOWS:
            raise InputError(f"{arguments.flow} cannot hold a flow in time; end it with {' or '.join(_FLOWS)}")
        check_flow_output(arguments.flow, arguments.overwrite)
    targets = [path.resolve() for path in (output, arguments.energy, arguments.flow) if path is not None]
    if len(set(targets)) < len(targets):
        raise InputError(f"{output} would be written twice; give every output a name of its own")


def _writers(
    arguments: argparse.Namespace, output: Path, kind: "Kind", made: "Metamorphosis[Tensor]", frames: "list[Tensor]"
) -> "dict[Path, Writer]":
    """What writes each file."""
    from synth.commands.report import energy_writer
    from synth.io.flows import flow_writer
    from synth.io.images import image_writer
    from synth.io.videos import video_writer
    from synth.morph.sheet import contact_sheet

    writers: dict[Path, Writer] = {}
    if _is_image(output):
        writers[output] = image_writer(output, contact_sheet(frames), kind)
    else:
        low, high = (
            (0.0, 1.0) if not kind.dtype.startswith("f") or not _is_video(output) else (made.form.low, made.form.high)
        )
        writers[output] = video_writer(output, ((f - low) / ((high - low) or 1.0) for f in frames), arguments.fps, kind)
    if arguments.energy is not None:
        writers[arguments.energy] = energy_writer(arguments.energy, made.film.energies)
    if arguments.flow is not None and made.film.velocity is not None:
        writers[arguments.flow] = flow_writer(arguments.flow, made.film.velocity)
    return writers


def _is_video(output: Path) -> bool:
    return output.suffix.lower() in _VIDEOS


def _is_image(output: Path) -> bool:
    return bool(output.suffix) and not _is_video(output)
