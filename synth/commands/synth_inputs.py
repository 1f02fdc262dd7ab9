"""What `kwatra synth` makes an image from, read and checked."""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import check_size
from synth.commands.guides import guides_of
from synth.commands.naming import output_of
from synth.commands.wishes import Wishes

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Array, Kind, Picture
    from synth.texture import Map


def size_of(pixels: "Tensor") -> tuple[int, int]:
    """(height, width) of pixels (C, H, W)."""
    return pixels.shape[1], pixels.shape[2]


@dataclass(frozen=True)
class Inputs:
    """What is synthesized from: exemplars (C, H, W) of one kind, and what goes with them; size: (height, width)."""

    exemplars: "list[Tensor]"
    kind: "Kind"
    start: "Picture | None"
    guides: "list[tuple[list[Array], Array]]"
    maps: "list[Map]"
    wishes: Wishes
    size: tuple[int, int]
    output: Path

    @classmethod
    def read(cls, arguments: argparse.Namespace) -> "Inputs":
        """What the arguments name, checked; InputError for what cannot be used."""
        pictures = [io.read_image(path) for path in arguments.exemplars]
        exemplars, kind = io.raised(pictures, arguments.exemplars)
        start = None if arguments.start is None else _read_start(arguments.start, kind, arguments.size)
        guides = guides_of(arguments, exemplars, kind)
        wishes = Wishes.read(arguments, kind, exemplars)
        given = {name: (size[0], size[1]) for name, size in wishes.sizes.items()}
        for guide in guides:
            given = {"the guide's output map": guide[1].shape[:2], **given}
        if start is not None:
            given = {"--start": size_of(start.pixels), **given}
        size = _output_size(arguments, exemplars[0], given)
        first = arguments.exemplars[0]
        output = output_of(arguments.output, f"{first.stem}_synth{first.suffix}")
        sizes = [size_of(exemplar) for exemplar in exemplars]
        maps = [texture.read_map(request, sizes, output) for request in arguments.also]
        return cls(exemplars, kind, start, guides, maps, wishes, size, output)


def _read_start(path: Path, kind: "Kind", size: tuple[int, int] | None) -> "Picture":
    start = io.read_image(path)
    if len(start.pixels) != len(kind.channels):
        raise synth.InputError(f"{path} holds {start.kind} but the exemplar {kind}; save it like the exemplar")
    if size is not None and size != size_of(start.pixels):
        height, width = size_of(start.pixels)
        raise synth.InputError(f"{path} is {width}x{height} but --size asks for {size[1]}x{size[0]}; leave --size out")
    return start


def _output_size(
    arguments: argparse.Namespace, exemplar: "Tensor", given: "dict[str, tuple[int, int]]"
) -> tuple[int, int]:
    """(height, width): as asked, or that of what is given of the output, by name; or else twice the exemplar's."""
    if arguments.tile == "nearest" and given:
        raise synth.InputError(f"--tile nearest chooses a size but {next(iter(given))} has one; use --tile alone")
    down, across = size_of(exemplar)
    height, width = arguments.size or next(iter(given.values()), (2 * down, 2 * across))
    for name, (down, across) in given.items():
        if (down, across) != (height, width):
            raise synth.InputError(f"{name} is {across}x{down} but the output {width}x{height}; give both one size")
    check_size((height, width))
    return height, width
