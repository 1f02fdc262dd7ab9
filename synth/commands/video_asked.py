"""What `kwatra synth VIDEO` is asked beside texture: guides, a start, and pixels; of stills or of videos."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from torch import Tensor

import synth
from synth import io, texture
from synth.commands.checks import check_memory
from synth.commands.framewise import digest
from synth.commands.guides import asks_for_labels, asks_for_tones, guide_weights, tones_of
from synth.commands.wishes import Wishes, in_frames, read_pixels, shown

if TYPE_CHECKING:
    from synth.io import Kind, Picture

_BYTES = 300
"""What a pixel of a video takes that is made as a whole."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked: a start (C, *S), guides of a map (C, T, H, W) for each exemplar and one (C, *S) of the output.

    S is (T, H, W), or (H, W) of a still, which is the same in all frames. outputs: what the guides are called.
    """

    wishes: Wishes
    start: "Picture | None"
    guides: list[tuple[list[Tensor], Tensor]]
    outputs: list[str]
    weights: float | list[float]

    @classmethod
    def read(cls, arguments: argparse.Namespace, exemplars: Sequence[Tensor], kind: "Kind") -> "Asked":
        """As the arguments ask, for exemplars (C, T, H, W) of a kind; InputError for files that do not fit."""
        weights = guide_weights(arguments)
        start = None if arguments.start is None else read_pixels(arguments.start, True)
        if start is not None and start.kind.channels != kind.channels:
            raise synth.InputError(f"{arguments.start} holds {start.kind} but the exemplar {kind}; save it alike")
        guides = [_guide(request, exemplars, kind) for request in arguments.guide]
        outputs = [f"--guide {request}" for request in arguments.guide]
        return cls(Wishes.read(arguments, kind, exemplars), start, guides, outputs, weights)

    @property
    def sizes(self) -> dict[str, tuple[int, ...]]:
        """What size, (H, W) or (T, H, W), all that is given of the output has, by option."""
        given: dict[str, tuple[int, ...]] = {} if self.start is None else {"--start": self.start.pixels.shape[1:]}
        for file, (_, output) in zip(self.outputs, self.guides, strict=True):
            given[file] = output.shape[1:]
        return given | self.wishes.sizes

    def agreed(self, asked: tuple[int | None, int | None, int | None]) -> tuple[int | None, int | None, int | None]:
        """(frames, height, width) as asked, else as what is given has them, else None; InputError where they differ."""
        frames, height, width = asked
        for name, given in self.sizes.items():
            if (height, width) not in ((None, None), given[-2:]):
                raise synth.InputError(f"{name} is {shown(given)} but the output {width}x{height}; give both one size")
            height, width = given[-2:]
            if len(given) == 3 and frames not in (None, given[0]):
                raise synth.InputError(f"{name} is {shown(given)} but the output has {frames}; give both one length")
            frames = given[0] if len(given) == 3 else frames
        return frames, height, width

    def check(self, size: tuple[int, int, int]) -> None:
        """Refuse what would not fit in memory: what is asked of pixels is heeded in the whole video at once."""
        if self.sizes:
            what = f"a video of {shown(size)}, made as a whole because something is asked of its pixels,"
            check_memory(_BYTES * size[0] * size[1] * size[2], what, "ask for fewer frames or a smaller size")

    def through(self, frames: int) -> "Asked":
        """The same for so many frames, stills for all of them."""
        start, guides = self.start, [(maps, in_frames(output, frames)) for maps, output in self.guides]
        if start is not None:
            start = replace(start, pixels=in_frames(start.pixels, frames))
        return replace(self, wishes=self.wishes.through(frames), start=start, guides=guides)

    def options(self, exemplars: Sequence[Tensor], device: str) -> dict[str, Any]:
        """The options of `synthesize` that say all this."""
        start = self.start
        return {
            "start": None if start is None else io.premultiplied(start.pixels, start.kind),
            "terms": self.wishes.terms(exemplars, device),
            "mask": self.wishes.mask,
            "guide": self.guides or None,
            "guide_weight": self.weights,
            "exemplar_mask": self.wishes.allowed,
        }

    @cached_property
    def settings(self) -> Mapping[str, str]:
        """What decides how frames look, by names that a user knows."""
        w = self.wishes
        given = {
            "--start": [] if self.start is None else [self.start.pixels],
            "--guide": [part for maps, output in self.guides for part in (*maps, output)],
            "--mask": [] if w.mask is None else [w.mask],
            "--keep": w.keep or [],
            "--soft": w.soft or [],
            "--exemplar-mask": w.allowed or [],
        }
        told = {name: " ".join(digest(part, str(name)) for part in parts) for name, parts in given.items()}
        return {**told, "--guide-weight": str(self.weights)}


def _guide(request: str, exemplars: Sequence[Tensor], kind: "Kind") -> tuple[list[Tensor], Tensor]:
    """A guide's maps, a still for all frames of its exemplar."""
    if asks_for_tones(request):
        return tones_of(request, exemplars, kind, lambda name: read_pixels(name, True))
    if asks_for_labels(request):
        raise synth.InputError(f"--guide {request} is for images; give a map of each clip, as A,B=OUTPUT_MAP")
    files = texture.guide_files(request, len(exemplars))
    *maps, output = [read_pixels(Path(file), True) for file in files]
    for file, each in zip(files, maps, strict=False):
        if each.kind != output.kind:
            raise synth.InputError(f"{file} holds {each.kind} but {files[-1]} holds {output.kind}; save both alike")
    frames = zip(files, maps, exemplars, strict=False)
    return [_of_exemplar(file, each.pixels, exemplar) for file, each, exemplar in frames], output.pixels


def _of_exemplar(file: Path, pixels: Tensor, exemplar: Tensor) -> Tensor:
    through = in_frames(pixels, exemplar.shape[1])
    if through.shape[1:] != exemplar.shape[1:]:
        raise synth.InputError(f"{file} is {shown(pixels.shape[1:])} but its exemplar {shown(exemplar.shape[1:])}; "
                               "a guide's map has its exemplar's size, and its length where it is a video")  # fmt: skip
    return through
