"""Pixels with given values: soft ones, which are wanted with a weight, and hard ones, which are kept exactly.

Soft pixels are the control term of thesis equations 23 and 25, sum_k w_k (x_k - c_k)^2, with a weight for each pixel
and, if need be, each channel. Hard pixels are its limit of infinite weight in the blend: x_k = c_k, and the texture
solves for the others. In the search, where an infinite weight would make windows blind to everything else, they count
with a finite one. Guidance (texture by numbers) is nothing but channels that are hard everywhere: the exemplar has
them too, so windows match on them, and they come back as they were given.
"""

from dataclasses import dataclass, replace

import torch
from torch import Tensor

from kwatra.base import InputError, coarse_shape, floats_of, resized, tensor_of
from kwatra.source.sourcemap import coarser
from kwatra.terms.algebra import Quadratic, Term


@dataclass(frozen=True)
class SoftPixels(Term):
    """Pixels wanted close to given values: sum_k w_k (x_k - c_k)^2 (thesis equations 23 and 25).

    target: c (C, *S) at the output's resolution. weight: w (C or 1, *S) >= 0, 0 where nothing is wanted.
    """

    target: Tensor
    weight: Tensor
    label: str = "soft pixels"

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", floats_of(self.target))
        object.__setattr__(self, "weight", floats_of(self.weight))
        _check_alike(self.label, "weights", self.target, self.weight)
        if not bool(self.weight.isfinite().all()) or bool((self.weight < 0).any()):
            raise InputError("a soft pixel's weight is negative, NaN or infinite; weights are finite and >= 0")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "SoftPixels":
        """Weights are averaged over blocks, targets averaged by weight."""
        _check_size(self.label, self.target, factor, shape)
        weight = resized(self.weight, factor, shape)
        total = resized(torch.where(self.weight > 0, self.weight * self.target, 0.0), factor, shape)
        return SoftPixels(total / weight.clamp(min=1e-12), weight, self.label)

    def within(self, mask: Tensor) -> "SoftPixels":
        """Without weight behind the mask."""
        return replace(self, weight=self.weight * mask)

    def quadratic(self, x: Tensor) -> Quadratic:
        """Diagonal: the weights."""
        return Quadratic(self.weight, self.target)


@dataclass(frozen=True)
class HardPixels(Term):
    """Pixels that keep given values, bit for bit.

    target: the values (C, *S) at the output's resolution; what it holds elsewhere does not matter. where: (C or 1,
    *S), True where a value is given; on a coarser level the share, 0 to 1, of each block that is. weight: how much
    more a hard pixel counts in the search than another (thesis equation 26), >= 0. source: (n, *S) whole numbers,
    where on the exemplar's canvas given pixels are copied from, with all channels, below 0 from nowhere; or None.
    Blocks that it begins with are then laid beside them as beside each other, not only where they are like them. Of
    stills it need not be told: what is a copy of the exemplar is found (`kwatra.loop.recognition`).
    """

    target: Tensor
    where: Tensor
    weight: float = 1.0
    label: str = "hard pixels"
    mask: Tensor | None = None
    source: Tensor | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", floats_of(self.target))
        object.__setattr__(self, "where", tensor_of(self.where))
        _check_alike(self.label, "places", self.target, self.where)
        if self.source is not None:
            object.__setattr__(self, "source", tensor_of(self.source).to(self.target.device))
            _check_source(self.label, self.target, self.source)
        if not (0 <= self.weight < float("inf")):
            raise InputError(f"the weight of hard pixels is {self.weight}; it is finite and >= 0")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "HardPixels":
        """A block of which every pixel is hard is hard, at their mean; one of which some are, wants theirs softly."""
        _check_size(self.label, self.target, factor, shape)
        if all(f == 1 for f in factor):
            return self
        given = self.where.float()
        share = resized(given, factor, shape)
        value = resized(torch.where(given > 0, self.target, 0.0), factor, shape) / share.clamp(min=1e-12)
        if self.mask is not None:
            share = share / resized(self.mask[None].float(), factor, shape).clamp(min=1e-12)
        source = None if self.source is None else coarser(self.source, factor, shape)
        return HardPixels(value, share, self.weight, self.label, source=source)

    def copied(self) -> Tensor | None:
        """The source of pixels that are given whole, -1 of others; None where none is told."""
        return None if self.source is None else torch.where((self.where == 1).all(0), self.source, -1)

    @property
    def all_copied(self) -> bool:
        """Whether the source is told of all pixels that are given, if only in part."""
        return self.source is not None and bool(((self.where <= 0).all(0) | (self.source >= 0).all(0)).all())

    def within(self, mask: Tensor) -> "HardPixels":
        """Not given behind the mask; there a block's pixels do not count."""
        return replace(self, where=self.where.float() * mask, mask=mask)

    def quadratic(self, x: Tensor) -> Quadratic:
        """Diagonal: the weight. Fixed: where all of a pixel is given."""
        given = self.where.float()
        return Quadratic(self.weight * given, torch.where(given > 0, self.target, 0.0), fixed=given == 1)


def _check_alike(label: str, what: str, target: Tensor, other: Tensor) -> None:
    fit = other.ndim == target.ndim > 1 and 0 not in target.shape and other.shape[1:] == target.shape[1:]
    if not fit or other.shape[0] not in (1, target.shape[0]):
        raise InputError(
            f"{label} have targets {tuple(target.shape)} but {what} {tuple(other.shape)}; give {what} of the same "
            "size with one channel or as many"
        )


def _check_source(label: str, target: Tensor, source: Tensor) -> None:
    whole = not (source.is_floating_point() or source.is_complex() or source.dtype == torch.bool)
    if not whole or tuple(source.shape) != (target.ndim - 1, *target.shape[1:]):
        raise InputError(
            f"{label} have a source {source.dtype} {tuple(source.shape)}; give whole numbers "
            f"{(target.ndim - 1, *target.shape[1:])}, a row for each axis"
        )


def _check_size(label: str, target: Tensor, factor: tuple[int, ...], shape: tuple[int, ...]) -> None:
    size = tuple(target.shape[1:])
    if len(size) != len(shape) or coarse_shape(size, factor) != tuple(shape):
        whole = tuple(s * f for s, f in zip(shape, factor, strict=True))
        raise InputError(
            f"{label} are given for an image of size {size}, but the output is {whole}; crop or pad them to its size"
        )
