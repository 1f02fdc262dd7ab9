"""All that is asked of an output besides being texture, on one level: its terms and its mask.

The mask (True = texture belongs here) takes part of every window and of every term away: windows match, and the blend
solves, on what is left (thesis section 6.3, K* and K_p* of equation 28). A masked pixel and a hard one are the same
thing to the blend, a pixel that is not free; inside, masked ones are 0, so that nothing behind the mask can show.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from kwatra.base import LARGEST, InputError, coarse_shape, resized
from kwatra.exemplar import Exemplar
from kwatra.terms.algebra import Charge, PlaceCharge, Quadratic, TermLike, charge_of, place_charge_of, within
from kwatra.terms.pixels import HardPixels

if TYPE_CHECKING:
    from kwatra.step import Step


@dataclass(frozen=True)
class Wish:
    """What all terms together want of each pixel: weights (C or 1, *S), values (C, *S)."""

    weight: Tensor
    value: Tensor


def wish_of(quadratics: Sequence[Quadratic], x: Tensor) -> Wish | None:
    """The terms as one diagonal wish about the current image, for the search (thesis equation 26).

    A diagonal F is taken as it is. Another is replaced by its diagonal and by the value that one Jacobi step from x
    would reach, c = x - F (x - c) / diag F, which has the same gradient at x.
    """
    if not any(bool((q.diagonal > 0).any()) for q in quadratics):
        return None
    weight = torch.zeros_like(x)
    pull = torch.zeros_like(x)
    for q in quadratics:
        weight = weight + q.diagonal
        pull = pull + q.times(x - q.target)
    return Wish(weight, torch.where(weight > 0, x - pull / weight.clamp(min=1e-12), x))


@dataclass(frozen=True)
class Given:
    """The values of an image that are not free: fixed (C, *S) boolean, value (C, *S); mask (1, *S) or None.

    Behind the mask every channel is fixed, at 0.
    """

    fixed: Tensor
    value: Tensor
    mask: Tensor | None

    @property
    def free(self) -> Tensor:
        """Pixels (1, *S) of which some channel is free."""
        return ~self.fixed.all(0, keepdim=True)

    def held(self, x: Tensor) -> Tensor:
        """The image with its fixed values in place."""
        return torch.where(self.fixed, self.value, x)


class Controls:
    """Terms and mask where pixels are `factors` times coarser than those of an output of `channels` and `shape`.

    mask: boolean (*shape) or None. given: what is not free on this level, None where all is.
    """

    def __init__(
        self,
        terms: Sequence[TermLike],
        mask: Tensor | None,
        factors: tuple[int, ...],
        shape: tuple[int, ...],
        channels: int,
        device: torch.device | str,
    ) -> None:
        self.shape, self.factors, self._full = coarse_shape(shape, factors), factors, mask
        self._channels, self._device = channels, device
        self.mask = None if mask is None else _coarse_mask(mask, factors, self.shape)
        self.terms = [(term if mask is None else within(term, mask)).at(factors, self.shape) for term in terms]
        self.given: Given | None = None
        if self.terms or self.mask is not None:
            blank = self.blank()
            self.given = _given(self.quadratics(blank), self.mask, blank)

    def blank(self) -> Tensor:
        """An image (C, *S) of 0, for terms to say what they want where there is none yet."""
        return torch.zeros(self._channels, *self.shape, dtype=torch.float32, device=self._device)

    def quadratics(self, x: Tensor) -> list[Quadratic]:
        """F and c of every term about the image x, without what lies behind the mask."""
        quadratics = [term.quadratic(x) for term in self.terms]
        return quadratics if self.mask is None else [_cut(q, self.mask) for q in quadratics]

    def charges(self, x: Tensor | None, step: "Step") -> list[Charge | None]:
        """What every term charges candidates; None for those whose quadratic says it (see `Term.charge`)."""
        return [charge_of(term, x, step) for term in self.terms]

    def place_charges(self, exemplar: Exemplar, width: tuple[int, ...]) -> list[tuple[str, PlaceCharge]]:
        """What terms charge for the places in an exemplar of this resolution that windows of `width` come from, each
        with the term's name, which several terms may have."""
        charges = [(term.name, place_charge_of(term, exemplar, self.shape, width)) for term in self.terms]
        return [(name, charge) for name, charge in charges if charge is not None]

    def wish(self, but: Tensor | None = None) -> Wish | None:
        """What the blocks of a start should agree with, where it can be told without an image: by diagonal terms.

        but (*S): pixels of which nothing is wished, as they are laid themselves.
        """
        if not self.terms:
            return None
        x = self.blank()
        quadratics = [q for q in self.quadratics(x) if q.apply is None]
        asked = [q if q.fixed is None else replace(q, diagonal=q.diagonal + q.fixed.float()) for q in quadratics]
        if but is not None:
            asked = [replace(q, diagonal=torch.where(but, 0.0, q.diagonal)) for q in asked]
        return wish_of(asked, x)

    def copied(self) -> Tensor | None:
        """Where given pixels are copied from in the exemplar (n, *S), -1 of others; None where no term tells.

        Of several terms the first decides.
        """
        told = [source for term in self.terms if isinstance(term, HardPixels) and (source := term.copied()) is not None]
        return reduce(lambda first, other: torch.where(first >= 0, first, other), told) if told else None

    def energies(self, x: Tensor) -> list[tuple[str, float]]:
        """Every term's name and value for the image x (C, *S)."""
        if self.mask is None:
            return [(term.name, term.energy(x)) for term in self.terms]
        values = [q.value(x) for q in self.quadratics(x)]
        return [(term.name, value) for term, value in zip(self.terms, values, strict=True)]

    def held(self, x: Tensor) -> Tensor:
        """The image with its given values in place, and 0 behind the mask."""
        return x if self.given is None else self.given.held(x)

    def shrunk(self, image: Tensor) -> Tensor:
        """An image (C, *shape) of the full resolution at this one: blocks averaged over their unmasked pixels."""
        if self._full is None:
            return self.held(resized(image, self.factors, self.shape))
        inside = self._full[None]
        total = resized(torch.where(inside, image, 0.0), self.factors, self.shape)
        return self.held(total / resized(inside.float(), self.factors, self.shape).clamp(min=1e-12))


def _coarse_mask(mask: Tensor, factors: tuple[int, ...], shape: tuple[int, ...]) -> Tensor:
    """(1, *shape): a block counts if any of its pixels does, so that no unmasked pixel is left without texture."""
    largest = LARGEST[len(shape)](mask[None, None].float(), factors, ceil_mode=True)
    return largest[0] > 0


def _cut(q: Quadratic, mask: Tensor) -> Quadratic:
    """A quadratic on unmasked pixels alone: M F M for F."""
    inside = mask.float()
    apply = None if q.apply is None else partial(_cut_product, q.apply, inside)
    diagonal, target = (torch.where(mask, t, 0.0) for t in (q.diagonal, q.target))
    return Quadratic(diagonal, target, apply, None if q.fixed is None else q.fixed & mask)


def _cut_product(apply: Callable[[Tensor], Tensor], inside: Tensor, x: Tensor) -> Tensor:
    return inside * apply(inside * x)


def _given(quadratics: Sequence[Quadratic], mask: Tensor | None, blank: Tensor) -> Given | None:
    """What is not free; where several terms fix a value they agree, as `check_controls` has seen to."""
    fixed, value = torch.zeros_like(blank, dtype=torch.bool), blank
    for q in quadratics:
        if q.fixed is not None:
            value = torch.where(q.fixed & ~fixed, q.target, value)
            fixed = fixed | q.fixed
    if mask is not None:
        fixed = fixed | ~mask
    return Given(fixed, value, mask) if bool(fixed.any()) else None


def check_controls(controls: Controls, canvas: Sequence[int] | None = None) -> None:
    """InputError for terms of another size, wishes that are no numbers, and hard pixels that contradict each other.

    canvas: the exemplar's shape, None if there is none; also for pixels that are copied from beyond it.
    """
    _check_copied(controls.copied(), canvas)
    x = controls.blank()
    fixed, value = torch.zeros_like(x, dtype=torch.bool), x.clone()
    for term, q in zip(controls.terms, controls.quadratics(x), strict=True):
        name = term.name
        for tensor in (q.diagonal, q.target):
            if tensor.shape[0] not in (1, len(x)) or tensor.shape[1:] != x.shape[1:]:
                raise InputError(
                    f"the term {name!r} is for images {tuple(tensor.shape)}, but the output is {tuple(x.shape)}; "
                    "give it the output's size and channels"
                )
        asked = q.diagonal > 0 if q.fixed is None else (q.diagonal > 0) | q.fixed
        if not bool(q.diagonal.isfinite().all()) or not bool((q.target.isfinite() | ~asked).all()):
            raise InputError(f"the term {name!r} has NaN or infinite weights or values; replace them or weigh them 0")
        if bool((q.diagonal < 0).any()):
            raise InputError(
                f"the term {name!r} has negative weights, with which there is no least energy; make them 0 or more"
            )
        if q.fixed is not None:
            clash = fixed & q.fixed & (value != q.target)
            if bool(clash.any()):
                where = tuple(clash.any(0).nonzero()[0].tolist())
                raise InputError(
                    f"hard pixels contradict each other: {name!r} fixes {int(clash.any(0).sum())} pixels, the first at "
                    f"{where}, that another term fixes at other values; keep one of them or make one soft"
                )
            value, fixed = torch.where(q.fixed, q.target, value), fixed | q.fixed


def _check_copied(source: Tensor | None, canvas: Sequence[int] | None) -> None:
    if source is None or canvas is None:
        return
    last = [int(line.max()) for line in source]
    if any(at >= size for at, size in zip(last, canvas, strict=True)):
        raise InputError(
            f"hard pixels are copied from places up to {tuple(last)}, but the exemplar's canvas has the shape "
            f"{tuple(canvas)}; give places on it, or below 0 where a pixel is copied from nowhere"
        )
