"""`kwatra flow`: a flow field by name or from a file, as a file or a picture."""

import argparse
from pathlib import Path

import torch
from torch import Tensor

import flow
from kwatra.base import InputError
from synth.io.flows import SUFFIXES, check_flow_output, field_of, flow_writer, read_flow
from synth.io.image_formats import Kind
from synth.io.images import Writer, check_output, image_writer, write_files

_PICTURE = Kind("uint8", ("R", "G", "B"))
_SIZE = (256, 256)


def run_flow(arguments: argparse.Namespace) -> str:
    """`kwatra flow`: returns the summary."""
    output, drawing = arguments.output, arguments.picture
    if output is None and drawing is None:
        raise InputError("there is nothing to write; name a file with -o, or a picture with --picture")
    if output is not None:
        check_flow_output(output, arguments.overwrite)
    if drawing is not None:
        check_output(drawing, _PICTURE, arguments.overwrite)
    if None not in (output, drawing) and output.resolve() == drawing.resolve():
        raise InputError(f"{output} would be written twice; give every output a name of its own")
    vectors, known = _vectors(arguments)
    first, seen = (vectors, known) if vectors.ndim == 3 else (vectors[0], known[0])
    writers: dict[Path, Writer] = {}
    if output is not None:
        writers[output] = flow_writer(output, vectors, known)
    if drawing is not None:
        writers[drawing] = image_writer(drawing, flow.picture(first, seen, arrows=arguments.arrows), _PICTURE)
    write_files(writers)
    height, width = first.shape[1:]
    frames = "" if vectors.ndim == 3 else f" in {len(vectors)} frames"
    fastest = float(torch.where(known.unsqueeze(-3), vectors, 0.0).norm(dim=-3).max())
    return f"wrote {' and '.join(map(str, writers))}: {width}x{height}{frames}, up to {fastest:.4g} px per frame"


def _vectors(arguments: argparse.Namespace) -> tuple[Tensor, Tensor]:
    """The flow (2, H, W) or (T, 2, H, W) and where it is known; a file's as it is, unless something is to change."""
    size, speed, frames = arguments.size, arguments.speed, arguments.frames
    if Path(arguments.field).suffix.lower() in SUFFIXES:
        recording = read_flow(arguments.field)
        if size is speed is frames is None:
            return recording.flow, recording.known
        size = size or tuple(recording.flow.shape[-2:])
        frames = frames or (1 if recording.flow.ndim == 3 else len(recording.flow))
    height, width = size or _SIZE
    if not (0 < height * width <= 2**28):
        raise InputError(f"--size is {width}x{height}; give 1 to 2^28 pixels")
    field = field_of(arguments.field, speed, resample=True)
    vectors = torch.stack([field(t, (height, width)) for t in range(frames or 1)])
    vectors = vectors[0] if len(vectors) == 1 else vectors
    return vectors, torch.ones_like(vectors.select(-3, 0), dtype=torch.bool)
