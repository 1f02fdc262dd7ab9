"""What the commands do: check everything, then work, then write everything. Each returns the text to print."""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor

from kwatra import InputError, measure
from synth.commands.progress import progress_line
from synth.commands.report import ENERGY_SUFFIXES, energy_writer, score_table
from synth.io.image_formats import Array, Kind
from synth.io.images import Picture, Writer, check_output, image_writer, read_image, write_files
from synth.texture.images import Synthesis, synthesize
from synth.texture.maps import Map, check_source_output, map_writer, read_guide, read_map, source_writer

_MOST_SIDE, _MOST_PIXELS = 2**16, 2**28


def run_synth(arguments: argparse.Namespace) -> str:
    """`kwatra synth`: returns the summary."""
    set_up(arguments.device, arguments.threads)
    exemplars = [read_image(path) for path in arguments.exemplars]
    _check_alike(arguments.exemplars, exemplars)
    start = None if arguments.start is None else _read_start(arguments.start, exemplars[0], arguments.size)
    guide = None if arguments.guide is None else read_guide(arguments.guide, len(exemplars))
    height, width = _output_size(arguments.size, exemplars[0], start, guide)
    first = arguments.exemplars[0]
    output = arguments.output or Path(f"{first.stem}_synth{first.suffix}")
    sizes = [_size_of(exemplar) for exemplar in exemplars]
    maps = [read_map(request, sizes, output) for request in arguments.also]
    _check_outputs(arguments, output, maps, exemplars)
    began = time.perf_counter()
    with progress_line(f"{first.name} to {width}x{height}") as callback:
        synthesis = synthesize(
            [exemplar.pixels for exemplar in exemplars],
            (height, width),
            preset=arguments.preset,
            seed=arguments.seed,
            tile=arguments.tile,
            start=None if start is None else start.pixels,
            levels=arguments.levels,
            mirror=arguments.mirror,
            rotate=arguments.rotate,
            scale=arguments.scale,
            guide=guide,
            guide_weight=arguments.guide_weight,
            device=arguments.device,
            callback=callback,
        )
    took = time.perf_counter() - began
    source = synthesis.source
    writers = {output: image_writer(output, synthesis.image, exemplars[0].kind)}
    writers |= {carried.output: map_writer(carried, synthesis) for carried in maps}
    if arguments.map is not None:
        writers[arguments.map] = source_writer(arguments.map, source)
    if arguments.energy is not None:
        writers[arguments.energy] = energy_writer(arguments.energy, synthesis.result.energies)
    if arguments.progress_images is not None:
        writers |= _stage_writers(arguments.progress_images, synthesis, exemplars[0].kind, output.suffix)
    write_files(writers)
    return f"wrote {_names(writers)}: {width}x{height} in {took:.1f} s ({synthesis.result.stopped})"


def run_score(arguments: argparse.Namespace) -> str:
    """`kwatra score`: returns a table, or JSON of one object per output file."""
    exemplar = read_image(arguments.exemplar)
    outputs = {str(path): read_image(path) for path in arguments.outputs}
    for path, output in outputs.items():
        if len(output.pixels) != len(exemplar.pixels):
            raise InputError(
                f"{path} holds {output.kind} but {arguments.exemplar} holds {exemplar.kind}; "
                "an output has its exemplar's channels"
            )
    scores = {path: measure(output.pixels, exemplar.pixels) for path, output in outputs.items()}
    if arguments.json:
        return json.dumps([{"output": path, **row} for path, row in scores.items()], indent=2)
    return score_table(scores)


def set_up(device: str, threads: int | None) -> None:
    """Set the number of threads; InputError for a device that is not there."""
    if device == "cuda" and not torch.cuda.is_available():
        raise InputError("--device is cuda but there is no CUDA device here; use cpu")
    if threads is not None:
        import faiss

        torch.set_num_threads(threads)
        faiss.omp_set_num_threads(threads)


def check_size(shape: tuple[int, int]) -> None:
    """Refuse a size (H, W) that nobody has the memory for."""
    height, width = shape
    if max(height, width) > _MOST_SIDE or height * width > _MOST_PIXELS:
        raise InputError(f"a size of {width}x{height} is too large; at most {_MOST_SIDE} a side and 2^28 pixels in all")


def _check_alike(paths: Sequence[Path], exemplars: Sequence[Picture]) -> None:
    """Several exemplars of one texture must mean the same by their channels and values."""
    first = exemplars[0].kind
    for path, exemplar in zip(paths, exemplars, strict=True):
        kind = exemplar.kind
        if len(kind.channels) != len(first.channels) or kind.dtype.startswith("f") != first.dtype.startswith("f"):
            raise InputError(f"{path} holds {kind} but {paths[0]} holds {first}; save all exemplars in the same way")


def _read_start(path: Path, exemplar: Picture, size: tuple[int, int] | None) -> Picture:
    start = read_image(path)
    if len(start.pixels) != len(exemplar.pixels):
        raise InputError(f"{path} holds {start.kind} but the exemplar {exemplar.kind}; save it like the exemplar")
    if size is not None and size != _size_of(start):
        height, width = _size_of(start)
        raise InputError(f"{path} is {width}x{height} but --size asks for {size[1]}x{size[0]}; leave --size out")
    return start


def _output_size(
    asked: tuple[int, int] | None, exemplar: Picture, start: Picture | None, guide: tuple[list[Array], Array] | None
) -> tuple[int, int]:
    """(height, width): as asked, or the start's or the guide's, or twice the exemplar's."""
    twice = [2 * side for side in _size_of(exemplar)]
    guided = None if guide is None else guide[1].shape[:2]
    height, width = asked or (_size_of(start) if start is not None else guided or twice)
    if guided is not None and guided != (height, width):
        raise InputError(
            f"the guide's output map is {guided[1]}x{guided[0]} but the output {width}x{height}; give both one size"
        )
    check_size((height, width))
    return height, width


def _size_of(picture: Picture) -> tuple[int, int]:
    return picture.pixels.shape[1], picture.pixels.shape[2]


def _check_outputs(
    arguments: argparse.Namespace, output: Path, maps: Sequence[Map], exemplars: Sequence[Picture]
) -> None:
    """Refuse before any work what could not be written after it."""
    overwrite, files = arguments.overwrite, [output, *(carried.output for carried in maps)]
    check_output(output, exemplars[0].kind, overwrite)
    for carried in maps:
        check_output(carried.output, carried.kind, overwrite)
    if arguments.map is not None:
        check_source_output(arguments.map, [_size_of(exemplar) for exemplar in exemplars], overwrite)
        files.append(arguments.map)
    if arguments.energy is not None:
        check_output(arguments.energy, None, overwrite, ENERGY_SUFFIXES)
        files.append(arguments.energy)
    if arguments.progress_images is not None:
        _check_folder(arguments.progress_images, overwrite)
    targets = [file.resolve() for file in files]
    twice = [file for file, target in zip(files, targets, strict=True) if targets.count(target) > 1]
    if twice:
        raise InputError(f"{twice[0]} would be written twice; give every output a name of its own")


def _check_folder(folder: Path, overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; name a folder for the progress images")
    if not folder.exists() and not folder.parent.is_dir():
        raise InputError(f"{folder} cannot be made because {folder.parent} does not exist; make that first")
    if folder.exists() and any(folder.glob("level_*")) and not overwrite:
        raise InputError(f"{folder} already holds progress images; name another folder or allow it with --overwrite")


def _stage_writers(folder: Path, synthesis: Synthesis[Tensor], kind: Kind, suffix: str) -> dict[Path, Writer]:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made ({error.strerror}); choose another") from error
    writers = {}
    for number, (stage, image) in enumerate(zip(synthesis.result.stages, synthesis.stages, strict=True), 1):
        path = folder / f"level_{number}_scale{stage.factor}_width{stage.width}{suffix}"
        writers[path] = image_writer(path, image, kind)
    return writers


def _names(writers: dict[Path, Writer]) -> str:
    names = [str(path) for path in writers]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
