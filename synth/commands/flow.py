"""`kwatra flow`: a flow field by name or from a file, as a file or a picture."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io
from synth.commands.checks import check_distinct, check_memory, check_size, finish, refuse_unused
from synth.commands.naming import output_of
from synth.commands.parsing import Subparsers, file, finite, frame_count, size, whole
from synth.words import counted, listed

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Writer

LOADS = ("synth.io.flows", "synth.io.images")

_SIZE = (256, 256)
_ARROWS = 16
_BYTES, _WORK = 50, 40
"""Memory per pixel: of each frame, and once; measured on sink, noise and waves of 2000x2000 pixels."""


def add(commands: Subparsers) -> None:
    """Add the command's arguments."""
    parser = commands.add_parser(
        "flow",
        help="a flow field by name or from a file, as a file or a picture",
        description="Write a flow field as a file of another format or draw a picture of it.",
    )
    add = parser.add_argument
    add("field", metavar="FIELD", help="uniform:ANGLE, rotation, sink, ... (another name lists them all), or a file")
    add("-o", "--output", type=file, metavar="OUT", help="the file to write: .flo, .png (KITTI), .npy or .npz; or "
        "the folder for FIELD.flo")  # fmt: skip
    add("--picture", type=file, metavar="FILE", help="draw it into this image: hue is direction, full color is fastest")
    add("--arrows", type=whole(0), metavar="PX", help=f"distance of its arrows (default: {_ARROWS}; 0: none)")
    add("--size", type=size, metavar="WIDTHxHEIGHT", help="size in pixels (default: 256x256; a file's own)")
    add("--speed", type=finite, metavar="PX", help="px per frame of the fastest pixel (default: 2; a file's own)")
    add("--frames", type=frame_count(1), metavar="N", help="how many in time (default: 1; as many as a file holds)")
    add("--overwrite", action="store_true", help="replace files that exist")


def run(arguments: argparse.Namespace) -> str:
    """Check everything, work, write everything; returns the summary."""
    import torch

    import flow

    color = io.Kind("uint8", ("R", "G", "B"))
    if Path(arguments.field).suffix.lower() not in io.FLOW_SUFFIXES:
        io.field_of(arguments.field, arguments.speed)  # a name that is none is told of before all else
    output, drawing = arguments.output, arguments.picture
    if output is not None:
        output = output_of(output, f"{Path(arguments.field).stem.replace(':', '')}.flo")
    outputs = [path for path in (output, drawing) if path is not None]
    if not outputs:
        raise synth.InputError("there is nothing to write; name a file with -o, or a picture with --picture")
    if output is not None:
        io.check_flow_output(output, arguments.overwrite)
    if drawing is not None:
        io.check_output(drawing, color, arguments.overwrite)
    else:
        refuse_unused(arguments, ["arrows"], "is for a --picture but there is none")
    check_distinct(outputs)
    vectors, known = _vectors(arguments)
    first, seen = (vectors, known) if vectors.ndim == 3 else (vectors[0], known[0])
    writers: dict[Path, Writer] = {}
    if output is not None:
        writers[output] = io.flow_writer(output, vectors, known)
    if drawing is not None:
        arrows = _ARROWS if arguments.arrows is None else arguments.arrows
        writers[drawing] = io.image_writer(drawing, flow.picture(first, seen, arrows=arrows), color)
    finish(writers, arguments.overwrite)
    height, width = first.shape[1:]
    frames = "" if vectors.ndim == 3 else f" in {counted(len(vectors), 'frame')}"
    fastest = float(torch.where(known.unsqueeze(-3), vectors, 0.0).norm(dim=-3).max())
    return f"wrote {listed(outputs)}: {width}x{height}{frames}, up to {fastest:.4g} px per frame"


def _vectors(arguments: argparse.Namespace) -> "tuple[Tensor, Tensor]":
    """The flow (2, H, W) or (T, 2, H, W) and where it is known; a file's as it is, unless something is to change."""
    import torch

    size, speed, frames = arguments.size, arguments.speed, arguments.frames
    if Path(arguments.field).suffix.lower() in io.FLOW_SUFFIXES:
        recording = io.read_flow(arguments.field)
        if size is speed is frames is None:
            return recording.flow, recording.known
        size = size or tuple(recording.flow.shape[-2:])
        frames = frames or (1 if recording.flow.ndim == 3 else len(recording.flow))
    height, width = size or _SIZE
    frames = frames or 1
    check_size((height, width))
    needed = height * width * (_BYTES * frames + _WORK)
    check_memory(
        needed,
        f"a flow of {width}x{height} in {counted(frames, 'frame')}",
        "ask for a smaller --size or fewer --frames",
    )
    field = io.field_of(arguments.field, speed, resample=True)
    vectors = torch.stack([field(t, (height, width)) for t in range(frames)])
    vectors = vectors[0] if len(vectors) == 1 else vectors
    return vectors, torch.ones_like(vectors.select(-3, 0), dtype=torch.bool)
