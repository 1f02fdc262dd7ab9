"""What `kwatra synth` is asked by guides: maps that say what belongs where, labels, or the tones that are wanted."""

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import synth
from synth import io, texture
from synth.commands.checks import refuse_unused
from synth.commands.parsing import positive
from synth.words import counted

if TYPE_CHECKING:
    from torch import Tensor

    from synth.io import Array, Kind, Picture

_TONES, _LABELS = "tones=", "labels="


def add_guides(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add = parser.add_argument
    add("--guide", action="append", default=[], metavar="MAP=MAP", help="EXEMPLAR_MAP=OUTPUT_MAP: put texture where "
        "the output's map is like the exemplar's (labels, a density, a direction); with several exemplars "
        "A,B=OUTPUT_MAP; labels=IMAGE: each of several exemplars where the image has its shade, the first where it is "
        "darkest; tones=IMAGE: where it is as light or dark as the image; may be given again")  # fmt: skip
    add("--guide-weight", type=positive, action="append", default=[], metavar="W", help="what the guide counts beside "
        "the colors, once for all or once for each; 0.1 to 0.3 suits maps that vary smoothly (default: 1; tones: "
        "0.3)")  # fmt: skip


def guide_weights(arguments: argparse.Namespace) -> float | list[float]:
    """One weight for all guides, or one for each; InputError for another number of them."""
    guides, weights = arguments.guide, arguments.guide_weight
    if not guides:
        refuse_unused(arguments, ["guide_weight"], "says what a --guide counts but there is none")
    if len(weights) > 1 and len(weights) != len(guides):
        raise synth.InputError(f"there are {counted(len(guides), '--guide')} but {counted(len(weights), 'weight')}; "
                               "give one --guide-weight for all, or one for each")  # fmt: skip
    if weights or not any(map(asks_for_tones, guides)):
        return weights if len(weights) > 1 else (weights or [1.0])[0]
    from synth.texture.toning import WEIGHT

    return [WEIGHT if asks_for_tones(guide) else 1.0 for guide in guides]


def guides_of(
    arguments: argparse.Namespace, exemplars: "Sequence[Tensor]", kind: "Kind"
) -> "list[tuple[list[Array], Array]]":
    """The guides of stills, each of maps for exemplars (C, H, W) of a kind and one of the output, all (H, W, G)."""
    guide_weights(arguments)
    made = []
    for request in arguments.guide:
        if asks_for_tones(request):
            maps, output = tones_of(request, exemplars, kind, io.read_image)
            made.append(([_rows_first(each) for each in maps], _rows_first(output)))
        elif asks_for_labels(request):
            made.append(_labels_of(request, [_rows_first(exemplar) for exemplar in exemplars]))
        else:
            made.append(texture.read_guide(request, len(exemplars)))
    return made


def asks_for_tones(request: str) -> bool:
    """Whether a `--guide` names no map of the exemplar but its tones."""
    return request.startswith(_TONES)


def asks_for_labels(request: str) -> bool:
    """Whether a `--guide` names no map of the exemplars but shades for them."""
    return request.startswith(_LABELS)


def tones_of(
    request: str, exemplars: "Sequence[Tensor]", kind: "Kind", read: "Callable[[str], Picture]"
) -> "tuple[list[Tensor], Tensor]":
    """The guide by tones of exemplars (C, *S) of a kind: a map (1, *S) for each, and the output's."""
    name = request.removeprefix(_TONES)
    if not name:
        raise synth.InputError(f"--guide is {request!r}; write {_TONES}IMAGE, an image as light and dark as is wanted")
    wanted = read(name)
    own, its = _colors(kind), _colors(wanted.kind)
    return texture.tones([exemplar[:own] for exemplar in exemplars], wanted.pixels[:its])


def _labels_of(request: str, exemplars: "Sequence[Array]") -> "tuple[list[Array], Array]":
    """The guide that puts exemplars (H, W, C) where an image has their shades."""
    name = request.removeprefix(_LABELS)
    if not name:
        raise synth.InputError(f"--guide is {request!r}; write {_LABELS}IMAGE, with a shade for each exemplar")
    wanted = io.read_image(name)
    colors = _colors(wanted.kind)
    return texture.labels(exemplars, _rows_first(wanted.pixels[:colors]))


def _rows_first(pixels: "Tensor") -> "Array":
    return pixels.permute(1, 2, 0).numpy()


def _colors(kind: "Kind") -> int:
    return sum(channel != "A" for channel in kind.channels)
