"""`kwatra fill`: check everything, fill the hole, write the image. Pixels stay as the file holds them."""

import argparse
import time
from pathlib import Path

from kwatra import InputError
from synth.commands.progress import progress_line
from synth.commands.synth import set_up
from synth.io.image_formats import Array, Kind
from synth.io.images import array_writer, check_output, read_array, read_mask, write_files
from synth.texture.filling import fill


def run_fill(arguments: argparse.Namespace) -> str:
    """`kwatra fill`: returns the summary."""
    set_up(arguments.device, arguments.threads)
    path = arguments.image
    image, kind = read_array(path)
    hole = read_mask(arguments.hole).numpy()
    if hole.shape != image.shape[:2]:
        raise InputError(
            f"{arguments.hole} is {hole.shape[1]}x{hole.shape[0]} but {path} {image.shape[1]}x{image.shape[0]}; "
            "a hole's mask has its image's size"
        )
    if not hole.any():
        raise InputError(f"{arguments.hole} is black everywhere; it is white where {path} is to be filled")
    exemplars = [_exemplar(each, path, kind) for each in arguments.exemplar] or None
    output = arguments.output or Path(f"{path.stem}_fill{path.suffix}")
    check_output(output, kind, arguments.overwrite)
    began = time.perf_counter()
    with progress_line(f"{path.name}, {int(hole.sum())} pixels") as callback:
        filled = fill(
            image,
            hole,
            exemplar=exemplars,
            preset=arguments.preset,
            seed=arguments.seed,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    write_files({output: array_writer(output, filled.image, kind)})
    return f"wrote {output}: {int(hole.sum())} pixels filled in {took:.1f} s ({filled.result.stopped})"


def _exemplar(path: Path, image: Path, kind: Kind) -> Array:
    array, own = read_array(path)
    if (own.dtype, own.channels) != (kind.dtype, kind.channels):
        raise InputError(f"{path} holds {own} but {image} holds {kind}; save the exemplar like the image")
    return array
