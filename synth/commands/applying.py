"""`--apply`: images rearranged as a map says that another run wrote with `--map`."""

import argparse
import time
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import finish
from synth.commands.naming import output_of
from synth.words import counted

if TYPE_CHECKING:
    from pathlib import Path

    from synth.io import Array

_HEEDED = ("command", "exemplars", "output", "apply", "overwrite", "threads", "options_given")
"""The arguments that count beside --apply."""


def apply(arguments: argparse.Namespace, default: "argparse.Namespace") -> str:
    """Rearrange the exemplars as `--apply` says and write the output; returns the summary.

    default: the arguments as they are where none is given. Raises InputError for one that would be ignored.
    """
    for name, value in vars(arguments).items():
        if name not in _HEEDED and name in vars(default) and value != getattr(default, name):
            option = f"--{name.replace('_', '-')}"
            raise synth.InputError(f"{option} is for what is synthesized but --apply only rearranges; leave it out")
    paths, first = arguments.exemplars, arguments.exemplars[0]
    arrays, kinds = zip(*(io.read_values(path) for path in paths), strict=True)
    for path, kind in zip(paths, kinds, strict=True):
        if (kind.dtype, kind.channels) != (kinds[0].dtype, kinds[0].channels):
            raise synth.InputError(f"{path} holds {kind} but {first} holds {kinds[0]}; save both alike")
    output = output_of(arguments.output, f"{first.stem}_synth{first.suffix}")
    io.check_output(output, kinds[0], arguments.overwrite)
    began, (source, turns) = time.perf_counter(), texture.read_source(arguments.apply)
    _check(arguments.apply, source, paths, arrays)
    made = texture.rearranged(first.stem, list(arrays), source, turns)
    finish({output: io.array_writer(output, made, kinds[0])}, arguments.overwrite)
    took = time.perf_counter() - began
    given = int((source[0] < 0).sum())
    empty = f", {counted(given, 'pixel')} of it from no image and so 0," if given else ""
    return f"wrote {output}: {source.shape[2]}x{source.shape[1]}{empty} as {arguments.apply} says, in {took:.1f} s"


def _check(name: "Path", source: "Array", paths: "list[Path]", arrays: "tuple[Array, ...]") -> None:
    """Refuse images that the map was not made for."""
    if int(source[0].max()) >= len(arrays):
        raise synth.InputError(
            f"{name} is of {counted(int(source[0].max()) + 1, 'image')} but {len(arrays)} given; give all of them"
        )
    for number, (path, array) in enumerate(zip(paths, arrays, strict=True)):
        here = source[1:, source[0] == number]
        if here.size and (here.min() < 0 or (here.max(1) >= array.shape[:2]).any()):
            height, width = (int(side) + 1 for side in here.max(1))
            raise synth.InputError(
                f"{name} takes pixels from {width}x{height} or more but {path} is {array.shape[1]}x{array.shape[0]}; "
                "give what belongs to the image it was made of"
            )
