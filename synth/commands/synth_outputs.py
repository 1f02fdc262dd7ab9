"""What `kwatra synth` writes of images: what is refused before any work, and the writers after it."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import check_distinct
from synth.commands.report import ENERGY_SUFFIXES, energy_writer
from synth.commands.synth_inputs import Inputs, size_of

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Kind, Writer
    from synth.texture import Synthesis


def check_outputs(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """Refuse before any work what could not be written after it."""
    overwrite, files = arguments.overwrite, [inputs.output, *(carried.output for carried in inputs.maps)]
    io.check_output(inputs.output, inputs.kind, overwrite)
    for carried in inputs.maps:
        io.check_output(carried.output, carried.kind, overwrite)
    if arguments.map is not None:
        texture.check_source_output(arguments.map, [size_of(exemplar) for exemplar in inputs.exemplars], overwrite)
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


def writers_of(arguments: argparse.Namespace, inputs: Inputs, synthesis: "Synthesis[Tensor]") -> "dict[Path, Writer]":
    """What writes each file, when all is done."""
    output, kind = inputs.output, inputs.kind
    made = inputs.wishes.kept(synthesis.image)
    writers = {output: io.image_writer(output, io.straight(made, kind), kind)}
    source, turns = synthesis.source, synthesis.turns
    writers |= {carried.output: texture.map_writer(carried, source, turns) for carried in inputs.maps}
    if arguments.map is not None:
        writers[arguments.map] = texture.source_writer(arguments.map, source, turns)
    if arguments.energy is not None:
        writers[arguments.energy] = energy_writer(arguments.energy, synthesis.result.energies)
    if arguments.progress_images is not None:
        writers |= _stage_writers(arguments.progress_images, synthesis, kind, output.suffix)
    return writers


def _stage_writers(folder: Path, synthesis: "Synthesis[Tensor]", kind: "Kind", suffix: str) -> "dict[Path, Writer]":
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise synth.InputError(f"{folder} cannot be made ({error.strerror}); choose another") from error
    writers = {}
    for level, (stage, image) in enumerate(zip(synthesis.result.stages, synthesis.stages, strict=True), 1):
        path = folder / f"level_{level}_scale{stage.factor}_width{stage.width}{suffix}"
        writers[path] = io.image_writer(path, io.straight(image, kind), kind)
    return writers
