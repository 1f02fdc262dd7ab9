"""What else the output should be: control terms of the energy (thesis section 6.1).

Every term is quadratic, lambda (x - c)^T F (x - c) with F symmetric positive semi-definite (thesis 6.1.1). It is
asked three things, always on the current level: its value `energy(x)`, its `quadratic(x)`, and through `at` what it
becomes at another resolution. What the search should know (equation 26) follows from the quadratic.
Terms add and scale: `2.0 * a + b`. Any class with these methods is a term; deriving from `Term` adds the algebra.

A weight of 1 makes a control count as much as the texture does on an average pixel.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.axes import AVERAGE
from kwatra.errors import InputError
from kwatra.reductions import mean


@dataclass(frozen=True)
class Quadratic:
    """lambda F and c of a term on one level.

    diagonal: weights (C or 1, *S) >= 0, the diagonal of lambda F. target: c (C or 1, *S). apply: the product of
    lambda F with an image (C, *S), for an F that is not diagonal; None where the diagonal is all of it.
    """

    diagonal: Tensor
    target: Tensor
    apply: Callable[[Tensor], Tensor] | None = None

    def times(self, x: Tensor) -> Tensor:
        """lambda F x."""
        return self.diagonal * x if self.apply is None else self.apply(x)

    def value(self, x: Tensor) -> float:
        """lambda (x - c)^T F (x - c), divided by the number of values in x."""
        error = x - self.target
        return float(mean(error * self.times(error)))


@runtime_checkable
class TermLike(Protocol):
    """What the engine needs of a term; a plain class with these members will do."""

    @property
    def name(self) -> str:
        """What it is called in reports."""

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "TermLike":
        """This term where pixels are `factor` times coarser than the output's (per axis) and the image is `shape`."""

    def energy(self, x: Tensor) -> float:
        """Its value for the image x (C, *shape), unweighted by resolution: a mean over pixels."""

    def quadratic(self, x: Tensor) -> Quadratic:
        """Its F and c; x is the current image, for terms that linearize about it."""


class Term(ABC):
    """A term with an algebra: `lambda * term` and `term + term`."""

    @property
    @abstractmethod
    def name(self) -> str:
        """See `TermLike.name`."""

    @abstractmethod
    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> TermLike:
        """See `TermLike.at`."""

    @abstractmethod
    def quadratic(self, x: Tensor) -> Quadratic:
        """See `TermLike.quadratic`."""

    def energy(self, x: Tensor) -> float:
        """See `TermLike.energy`."""
        return self.quadratic(x).value(x)

    def __mul__(self, factor: float) -> "Term":
        return Scaled(factor, self)

    __rmul__ = __mul__

    def __add__(self, other: "TermLike | Sum") -> "Sum":
        return Sum((*parts_of(self), *parts_of(other)))


@dataclass(frozen=True)
class Scaled(Term):
    """`factor` (>= 0, finite) times any term."""

    factor: float
    term: TermLike

    def __post_init__(self) -> None:
        if not (0 <= self.factor < float("inf")):
            raise InputError(f"a term is scaled by {self.factor}; weights are finite and >= 0")

    @property
    def name(self) -> str:
        """The inner term's name."""
        return self.term.name

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "Scaled":
        """See `TermLike.at`."""
        return Scaled(self.factor, self.term.at(factor, shape))

    def energy(self, x: Tensor) -> float:
        """The factor times the inner term's energy."""
        return self.factor * self.term.energy(x)

    def quadratic(self, x: Tensor) -> Quadratic:
        """The inner quadratic with lambda F scaled."""
        inner, factor = self.term.quadratic(x), self.factor
        apply = None if inner.apply is None else lambda v: factor * inner.times(v)
        return Quadratic(factor * inner.diagonal, inner.target, apply)


@dataclass(frozen=True)
class Sum:
    """Several terms as one; the engine takes it apart again, so each is reported by its own name."""

    terms: tuple[TermLike, ...]

    def __add__(self, other: "TermLike | Sum") -> "Sum":
        return Sum((*self.terms, *parts_of(other)))

    def __rmul__(self, factor: float) -> "Sum":
        return Sum(tuple(Scaled(factor, t) for t in self.terms))

    __mul__ = __rmul__


def parts_of(terms: "TermLike | Sum | Sequence[TermLike | Sum]") -> tuple[TermLike, ...]:
    """The single terms of a term, a sum, or a sequence of either; InputError for what is not a term."""
    if isinstance(terms, Sum):
        return terms.terms
    if isinstance(terms, Sequence):
        return tuple(part for item in terms for part in parts_of(item))
    missing = [member for member in ("name", "at", "energy", "quadratic") if not hasattr(terms, member)]
    if missing:
        raise InputError(
            f"{type(terms).__name__} is not a term, it has no {', '.join(missing)}; see kwatra.TermLike for what a "
            "term offers"
        )
    return (terms,)


def resized(image: Tensor, factor: tuple[int, ...], shape: tuple[int, ...]) -> Tensor:
    """An image (C, *S) averaged over blocks of `factor` pixels; a block that the border cuts averages what it has."""
    padding = []
    for size, f, there in zip(reversed(image.shape[1:]), reversed(factor), reversed(shape), strict=True):
        padding += [0, there * f - size]
    padded = F.pad(image[None], padding, mode="replicate") if any(padding) else image[None]
    return AVERAGE[len(shape)](padded, factor)[0]


@dataclass(frozen=True)
class SoftPixels(Term):
    """Pixels wanted close to given values: sum_k w_k (x_k - c_k)^2 (thesis equations 23 and 25).

    target: c (C, *S) at the output's resolution. weight: w (C or 1, *S) >= 0, 0 where nothing is wanted.
    """

    target: Tensor
    weight: Tensor
    label: str = "soft pixels"

    def __post_init__(self) -> None:
        if self.weight.shape[1:] != self.target.shape[1:] or self.weight.shape[0] not in (1, self.target.shape[0]):
            raise InputError(
                f"soft pixels have targets {tuple(self.target.shape)} but weights {tuple(self.weight.shape)}; give "
                "weights of the same size with one channel or as many"
            )
        if not bool(self.weight.isfinite().all()) or bool((self.weight < 0).any()):
            raise InputError("a soft pixel's weight is negative, NaN or infinite; weights are finite and >= 0")

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> "SoftPixels":
        """Weights are averaged over blocks, targets averaged by weight."""
        weight = resized(self.weight, factor, shape)
        total = resized(torch.where(self.weight > 0, self.weight * self.target, 0.0), factor, shape)
        return SoftPixels(total / weight.clamp(min=1e-12), weight, self.label)

    def quadratic(self, x: Tensor) -> Quadratic:
        """Diagonal: the weights."""
        return Quadratic(self.weight, self.target)


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
    if not quadratics:
        return None
    weight = torch.zeros_like(x)
    pull = torch.zeros_like(x)
    for q in quadratics:
        weight = weight + q.diagonal
        pull = pull + q.times(x - q.target)
    return Wish(weight, torch.where(weight > 0, x - pull / weight.clamp(min=1e-12), x))
