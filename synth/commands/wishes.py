"""What `kwatra synth` is asked of single pixels: where texture belongs, which are given, and what may be copied."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import synth
from synth import io
from synth.commands.checks import refuse_unused
from synth.commands.parsing import mask, positive
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Kind, Picture

_TONE = 0.05
"""What soft pixels count beside the texture: it suits pictures that the texture could have made, if not quite so."""


def add_wishes(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add = parser.add_argument
    add("--mask", type=mask, metavar="FILE", help="white where texture belongs, of the output's size; elsewhere the "
        "output is empty, or as --start; of a video, as with the next ones, a video or a still for all "
        "frames")  # fmt: skip
    add("--keep", metavar="IMAGE[=MASK]", help="pixels that the output has exactly: of an image of its size the opaque "
        "ones, or those white in a mask")  # fmt: skip
    add("--soft", metavar="IMAGE[=WEIGHTS]", help="pixels that the output is to be like, as far as the texture allows: "
        "weights from black to white, or alpha; for flat tones, which it has not, see --guide tones=IMAGE")  # fmt: skip
    add("--soft-weight", type=positive, metavar="W", help="what they count where white, beside the texture's 1 "
        f"(default: {_TONE:g})")  # fmt: skip
    add("--exemplar-mask", metavar="FILE[,FILE]", help="white where an exemplar may be copied from, of its size; with "
        "several exemplars one for each")  # fmt: skip


@dataclass(frozen=True)
class Wishes:
    """What is asked, for an output of C channels; None where nothing is.

    S is (H, W), or (T, H, W) of a video, of which a still may be given for all frames. mask: boolean (*S). keep: pixels
    (C, *S) and where (*S) they are kept. soft: pixels (C, *S) and weights (1, *S). allowed: boolean for each exemplar,
    of its size. sizes: what these are, by option.
    """

    mask: "Tensor | None"
    keep: "tuple[Tensor, Tensor] | None"
    soft: "tuple[Tensor, Tensor] | None"
    allowed: "list[Tensor] | None"
    sizes: dict[str, tuple[int, ...]]

    @classmethod
    def read(cls, arguments: argparse.Namespace, kind: "Kind", exemplars: "Sequence[Tensor]") -> "Wishes":
        """As the arguments ask, for exemplars (C, *S); InputError for files that do not fit."""
        video = exemplars[0].ndim == 4
        if arguments.soft is None:
            refuse_unused(arguments, ["soft_weight"], "says what --soft pixels count but there are none")
        belongs = None if arguments.mask is None else read_white(arguments.mask, video)
        if belongs is not None and not bool(belongs.any()):
            raise synth.InputError(f"{arguments.mask} is black everywhere; it is white where texture belongs")
        keep = None if arguments.keep is None else _pixels(arguments.keep, "--keep", kind, video)
        soft = None if arguments.soft is None else _pixels(arguments.soft, "--soft", kind, video)
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

    def through(self, frames: int) -> "Wishes":
        """The same for a video of so many frames, stills for all of them."""
        mask, keep, soft = self.mask, self.keep, self.soft
        return replace(
            self,
            mask=None if mask is None else in_frames(mask[None], frames)[0],
            keep=None if keep is None else (in_frames(keep[0], frames), in_frames(keep[1][None], frames)[0]),
            soft=None if soft is None else (in_frames(soft[0], frames), in_frames(soft[1], frames)),
        )

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

    def kept(self, image: "Tensor", frame: int | None = None) -> "Tensor":
        """The output (C, H, W), or a frame of it, with the very pixels it was to keep."""
        if self.keep is None:
            return image
        pixels, where = self.keep
        return image.where(~where, pixels) if frame is None else image.where(~where[frame], pixels[:, frame])


def in_frames(pixels: "Tensor", frames: int) -> "Tensor":
    """A still (C, H, W) as a video (C, T, H, W) of so many frames; a video as it is."""
    return pixels if pixels.ndim == 4 else pixels[:, None].expand(-1, frames, -1, -1)


def read_pixels(path: str | Path, video: bool) -> "Picture":
    """An image (C, H, W), or where a `video` will do the frames (C, T, H, W) of one."""
    if video and io.is_video(path):
        clip = io.read_video(path)
        return io.Picture(clip.frames, clip.kind)
    return io.read_image(path)


def read_white(path: Path, video: bool) -> "Tensor":
    """A mask (H, W), or (T, H, W) of a video where one will do: see `io.read_mask`."""
    name = str(path).removeprefix("not:")
    if not (video and io.is_video(name)):
        return io.read_mask(path)
    clip = io.read_video(name)
    seen = clip.frames[-1] if clip.kind.channels[-1] == "A" and bool((clip.frames[-1] < 1).any()) else None
    white = (clip.frames[: len(clip.frames) - (clip.kind.channels[-1] == "A")].mean(0) if seen is None else seen) > 0.5
    return ~white if str(path) != name else white


def _pixels(request: str, option: str, kind: "Kind", video: bool) -> "tuple[Tensor, Tensor]":
    """Pixels (C, *S) to be mixed, and weights (*S) in [0, 1]: a mask's, or the image's own alpha."""
    name, equals, other = request.partition("=")
    picture = read_pixels(name, video)
    wanted = [channel for channel in kind.channels if channel != "A"]
    colors = [channel for channel in picture.kind.channels if channel != "A"]
    if len(colors) != len(wanted) or ("A" in kind.channels and "A" not in picture.kind.channels):
        raise synth.InputError(f"{name} holds {picture.kind} but the exemplar {kind}; save it with the same channels")
    if equals:
        values = read_pixels(other.removeprefix("not:"), video).pixels.mean(0).clamp(0, 1)
        weight = 1 - values if other.startswith("not:") else values
        there = picture.pixels.shape[1:]
        weight = weight.expand(there) if weight.shape == there[-2:] else weight
        if weight.shape[-2:] != there[-2:] or (len(there) == weight.ndim and weight.shape != there):
            raise synth.InputError(f"{other} is {shown(weight.shape)} but {name} {shown(there)}; give both one size")
    elif "A" in picture.kind.channels:
        weight = picture.pixels[picture.kind.channels.index("A")]
    else:
        raise synth.InputError(f"{option} {name} does not say which pixels; write {option} {name}=MASK")
    pixels = io.premultiplied(picture.pixels, picture.kind) if "A" in kind.channels else picture.pixels[: len(wanted)]
    return (in_frames(pixels, len(weight)) if weight.ndim == 3 else pixels), weight


def _allowed(arguments: argparse.Namespace, exemplars: "Sequence[Tensor]") -> "list[Tensor]":
    names = arguments.exemplar_mask.split(",") if len(exemplars) > 1 else [arguments.exemplar_mask]
    if len(names) != len(exemplars):
        raise synth.InputError(f"--exemplar-mask names {counted(len(names), 'file')} for "
                               f"{counted(len(exemplars), 'exemplar')}; give one each, with commas")  # fmt: skip
    masks = [read_white(Path(name), exemplars[0].ndim == 4) for name in names]
    for number, (name, exemplar) in enumerate(zip(names, exemplars, strict=True)):
        if exemplar.ndim == 4:
            masks[number] = in_frames(masks[number][None], exemplar.shape[1])[0]
        allowed = masks[number]
        if allowed.shape != exemplar.shape[1:]:
            raise synth.InputError(f"{name} is {shown(allowed.shape)} but its exemplar {shown(exemplar.shape[1:])}; "
                                   "a mask has its exemplar's size")  # fmt: skip
        if not bool(allowed.any()):
            raise synth.InputError(f"{name} is black everywhere and leaves nothing to copy; white is copied")
    return masks


def _size(given: "Tensor | tuple[Tensor, Tensor]") -> tuple[int, ...]:
    """The size *S of a mask (*S), or of pixels (C, *S), that come with their weights."""
    return tuple(given[0].shape[1:] if isinstance(given, tuple) else given.shape)


def shown(shape: "Sequence[int]") -> str:
    """A size (H, W), or (T, H, W), in words."""
    of = f"{counted(shape[0], 'frame')} of " if len(shape) == 3 else ""
    return f"{of}{shape[-1]}x{shape[-2]}"
