"""What `kwatra synth` is asked of single pixels: where texture belongs, which are given, and what may be copied."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import synth
from synth import io
from synth.commands.checks import refuse_unused
from synth.commands.parsing import mask, positive
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Kind

_TONE = 0.05
"""What soft pixels count beside the texture: it suits pictures that the texture could have made, if not quite so."""


def add_wishes(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add = parser.add_argument
    add("--mask", type=mask, metavar="FILE", help="white where texture belongs, of the output's size; elsewhere the "
        "output is empty, or as --start")  # fmt: skip
    add("--keep", metavar="IMAGE[=MASK]", help="pixels that the output has exactly: of an image of its size the opaque "
        "ones, or those white in a mask")  # fmt: skip
    add("--soft", metavar="IMAGE[=WEIGHTS]", help="pixels that the output is to be like, as far as the texture allows: "
        "weights from black to white, or alpha; for flat tones, which it has not, --guide is better")  # fmt: skip
    add("--soft-weight", type=positive, metavar="W", help="what they count where white, beside the texture's 1 "
        f"(default: {_TONE:g})")  # fmt: skip
    add("--exemplar-mask", metavar="FILE[,FILE]", help="white where an exemplar may be copied from, of its size; with "
        "several exemplars one for each")  # fmt: skip


@dataclass(frozen=True)
class Wishes:
    """What is asked, for an output (H, W) of an exemplar of C channels; None where nothing is.

    mask: boolean (H, W). keep: pixels (C, H, W) and where (H, W) they are kept. soft: pixels (C, H, W) and weights
    (1, H, W). allowed: boolean (H, W) for each exemplar. sizes: what these are, by option.
    """

    mask: "Tensor | None"
    keep: "tuple[Tensor, Tensor] | None"
    soft: "tuple[Tensor, Tensor] | None"
    allowed: "list[Tensor] | None"
    sizes: dict[str, tuple[int, int]]

    @classmethod
    def read(cls, arguments: argparse.Namespace, kind: "Kind", exemplars: "Sequence[Tensor]") -> "Wishes":
        """As the arguments ask; InputError for files that do not fit."""
        if arguments.soft is None:
            refuse_unused(arguments, ["soft_weight"], "says what --soft pixels count but there are none")
        belongs = None if arguments.mask is None else io.read_mask(arguments.mask)
        keep = None if arguments.keep is None else _pixels(arguments.keep, "--keep", kind)
        soft = None if arguments.soft is None else _pixels(arguments.soft, "--soft", kind)
        if keep is not None:
            keep = keep[0], keep[1] > 0.5
            if not bool(keep[1].any()):
                raise synth.InputError(f"--keep {arguments.keep} keeps no pixel; the white or opaque ones are kept")
        if soft is not None:
            soft = soft[0], soft[1][None] * (arguments.soft_weight or _TONE)
        sizes = {f"--{name}": _size(given) for name, given in (("mask", belongs), ("keep", keep), ("soft", soft))
                 if given is not None}  # fmt: skip
        allowed = None if arguments.exemplar_mask is None else _allowed(arguments, exemplars)
        return cls(belongs, keep, soft, allowed, sizes)

    def terms(self, exemplars: "Sequence[Tensor]", device: str) -> list[Any]:
        """The terms, in the values that the exemplars' least and largest make 0 and 1."""
        import kwatra

        low = min(float(exemplar.min()) for exemplar in exemplars)
        range_of_values = (max(float(exemplar.max()) for exemplar in exemplars) - low) or 1.0
        terms: list[Any] = []
        if self.keep is not None:
            target, where = self.keep
            terms.append(kwatra.HardPixels(((target - low) / range_of_values).to(device), where[None].to(device)))
        if self.soft is not None:
            target, weight = self.soft
            terms.append(kwatra.SoftPixels(((target - low) / range_of_values).to(device), weight.to(device)))
        return terms

    def kept(self, image: "Tensor") -> "Tensor":
        """The output (C, H, W) with the very pixels it was to keep."""
        if self.keep is None:
            return image
        return image.where(~self.keep[1], self.keep[0])


def _pixels(request: str, option: str, kind: "Kind") -> "tuple[Tensor, Tensor]":
    """Pixels (C, H, W) to be mixed, and weights (H, W) in [0, 1]: a mask's, or the image's own alpha."""
    name, equals, other = request.partition("=")
    picture = io.read_image(name)
    wanted = [channel for channel in kind.channels if channel != "A"]
    colors = [channel for channel in picture.kind.channels if channel != "A"]
    if len(colors) != len(wanted) or ("A" in kind.channels and "A" not in picture.kind.channels):
        raise synth.InputError(f"{name} holds {picture.kind} but the exemplar {kind}; save it with the same channels")
    if equals:
        values = io.read_image(other.removeprefix("not:")).pixels.mean(0).clamp(0, 1)
        weight = 1 - values if other.startswith("not:") else values
        if weight.shape != picture.pixels.shape[1:]:
            raise synth.InputError(f"{other} is {_shown(weight.shape)} but {name} {_shown(picture.pixels.shape[1:])}; "
                                   "give both one size")  # fmt: skip
    elif "A" in picture.kind.channels:
        weight = picture.pixels[picture.kind.channels.index("A")]
    else:
        raise synth.InputError(f"{option} {name} does not say which pixels; write {option} {name}=MASK")
    pixels = io.premultiplied(picture.pixels, picture.kind) if "A" in kind.channels else picture.pixels[: len(wanted)]
    return pixels, weight


def _allowed(arguments: argparse.Namespace, exemplars: "Sequence[Tensor]") -> "list[Tensor]":
    names = arguments.exemplar_mask.split(",") if len(exemplars) > 1 else [arguments.exemplar_mask]
    if len(names) != len(exemplars):
        raise synth.InputError(f"--exemplar-mask names {counted(len(names), 'file')} for "
                               f"{counted(len(exemplars), 'exemplar')}; give one each, with commas")  # fmt: skip
    masks = [io.read_mask(Path(name)) for name in names]
    for name, allowed, exemplar in zip(names, masks, exemplars, strict=True):
        if allowed.shape != exemplar.shape[1:]:
            raise synth.InputError(f"{name} is {_shown(allowed.shape)} but its exemplar {_shown(exemplar.shape[1:])}; "
                                   "a mask has its exemplar's size")  # fmt: skip
        if not bool(allowed.any()):
            raise synth.InputError(f"{name} is black everywhere and leaves nothing to copy; white is copied")
    return masks


def _size(given: Any) -> tuple[int, int]:
    shape = (given[0] if isinstance(given, tuple) else given).shape
    return int(shape[-2]), int(shape[-1])


def _shown(shape: "Sequence[int]") -> str:
    return f"{shape[1]}x{shape[0]}"
