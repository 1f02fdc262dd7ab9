"""Pictures of several kinds as pictures of one: the richest, so that nothing is clipped or thrown away."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import torch
from torch import Tensor

from kwatra.base import InputError
from synth.io.alpha import straight
from synth.io.images import Picture
from synth.io.kinds import RGB, USUAL, Kind

_DEPTHS = ("bool", "uint8", "uint16", "float16", "float32", "float64")


def raised(pictures: Sequence[Picture], paths: Sequence[Path]) -> tuple[list[Tensor], Kind]:
    """The pixels of pictures in one kind, and that: color where any has color, alpha where any has, the greatest depth.

    Gray becomes color, what has no alpha is opaque, integers among floats are in [0, 1]. The color profile is the
    first's. Raises InputError for channels that no other picture can gain.
    """
    common = richest([picture.kind for picture in pictures], paths)
    return [as_kind(picture.pixels, picture.kind, common) for picture in pictures], common


def richest(kinds: Sequence[Kind], paths: Sequence[Path]) -> Kind:
    """The kind that pictures of several kinds are raised to; see `raised`."""
    if len({(kind.channels, kind.dtype, kind.premultiplied) for kind in kinds}) == 1:
        return kinds[0]
    for path, kind in zip(paths, kinds, strict=True):
        if kind.channels != kinds[0].channels and not {kind.channels, kinds[0].channels} <= set(USUAL.values()):
            raise InputError(f"{path} holds {kind} but {paths[0]} holds {kinds[0]}; save both with the same channels")
    colors = next((kind.channels[:3] for kind in kinds if kind.channels[:3] == RGB), kinds[0].channels[:1])
    alpha = any("A" in kind.channels for kind in kinds)
    usual = kinds[0].channels in USUAL.values()
    channels = (*colors, *(("A",) if alpha else ())) if usual else kinds[0].channels
    return Kind(_deepest(kinds), channels, profile=kinds[0].profile)


def as_kind(pixels: Tensor, own: Kind, kind: Kind) -> Tensor:
    """Pixels (C, *S) of their own kind in that, of as many or more channels, which they and others are raised to."""
    if own.channels == kind.channels and own.premultiplied == kind.premultiplied:
        return pixels
    unmultiplied = straight(pixels, replace(own, premultiplied=False)) if own.premultiplied else pixels
    return _with_channels(unmultiplied, own, kind) if kind.channels in USUAL.values() else unmultiplied


def _deepest(kinds: Sequence[Kind]) -> str:
    names = {kind.dtype for kind in kinds}
    deepest = max(names, key=_DEPTHS.index)
    return "float32" if deepest == "float16" and "uint16" in names else deepest  # half floats hold 11 bits


def _with_channels(pixels: Tensor, own: Kind, kind: Kind) -> Tensor:
    """Gray or color pixels with the channels of a kind that has as many or more."""
    opaque = "A" not in own.channels
    colors = pixels if opaque else pixels[:-1]
    colors = colors.expand(len(kind.channels) - ("A" in kind.channels), *colors.shape[1:])
    if "A" not in kind.channels:
        return colors.contiguous()
    return torch.cat([colors, torch.ones_like(colors[:1]) if opaque else pixels[-1:]])
