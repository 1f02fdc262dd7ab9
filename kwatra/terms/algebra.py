"""What else the output should be: control terms of the energy (thesis section 6.1).

Every term is quadratic, lambda (x - c)^T F (x - c) with F symmetric positive semi-definite (thesis 6.1.1). It is
asked three things, always on the current level: its value `energy(x)`, its `quadratic(x)`, and through `at` what it
becomes at another resolution. What the search should know (equation 26) follows from the quadratic, unless a term
charges candidates itself (equation 31).
Terms add and scale: `2.0 * a + b`. Any class with these methods is a term; deriving from `Term` adds the algebra.

A weight of 1 makes a control count as much as the texture does on an average pixel.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from torch import Tensor

from kwatra.base import InputError, mean
from kwatra.exemplar import Exemplar

if TYPE_CHECKING:
    from kwatra.step import Step


@dataclass(frozen=True)
class Quadratic:
    """lambda F and c of a term on one level.

    diagonal: weights (C or 1, *S) >= 0, the diagonal of lambda F. target: c (C or 1, *S). apply: the product of
    lambda F with an image (C, *S), for an F that is not diagonal; None where the diagonal is all of it. fixed:
    boolean (C or 1, *S), where the image must be the target exactly; there the diagonal only says how much the
    search should mind.
    """

    diagonal: Tensor
    target: Tensor
    apply: Callable[[Tensor], Tensor] | None = None
    fixed: Tensor | None = None

    def times(self, x: Tensor) -> Tensor:
        """lambda F x."""
        return self.diagonal * x if self.apply is None else self.apply(x)

    def scaled(self, factor: float | Tensor) -> "Quadratic":
        """The same with lambda times a factor >= 0, a number or a scalar."""
        apply = None if self.apply is None else lambda x: factor * self.times(x)
        return Quadratic(factor * self.diagonal, self.target, apply, self.fixed)

    def value(self, x: Tensor) -> float:
        """lambda (x - c)^T F (x - c), divided by the number of values in x."""
        error = x - self.target
        return float(mean(error * self.times(error)))


Charge = Callable[[Tensor, Tensor], Tensor]
"""What it costs a term to put source windows (N, *width, C) at corners (N, n) of the image: (N,), in the units of a
squared distance of windows, a mean over their pixels and channels."""


PlaceCharge = Callable[[Tensor, Tensor], Tensor]
"""What it costs a term that windows at corners (N, n) of the image come from corners (N, k, n) of an exemplar's canvas:
(N, k) >= 0, in the units of `Charge`. No pixel is looked at."""


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

    def charge(self, x: Tensor | None, step: "Step") -> Charge | None:
        """What the search should charge candidates, the rest of the image x (C, *S) as it is (thesis equation 31).

        x is None before there is an image: then only a window's own pixels can be charged for. None, the default, where
        the quadratic says all there is to know. A class of your own may leave this out.
        """
        return None

    def place_charge(self, exemplar: Exemplar, shape: tuple[int, ...], width: tuple[int, ...]) -> PlaceCharge | None:
        """What the search should charge candidates for the place they come from; None, the default, for nothing.

        exemplar and the output's shape *S are at one resolution; width: of the windows, or blocks, that are placed. A
        class of your own may leave this out.
        """
        return None

    def within(self, mask: Tensor) -> TermLike:
        """This term without what it wants behind the output's mask (*S), which is False there.

        Only for terms whose coarser versions would mix pixels before and behind the mask; others are cut off by the
        engine, level by level. A class of your own may leave this out.
        """
        return self

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

    def within(self, mask: Tensor) -> "Scaled":
        """See `Term.within`."""
        return Scaled(self.factor, within(self.term, mask))

    def charge(self, x: Tensor | None, step: "Step") -> Charge | None:
        """The factor times the inner term's charge."""
        inner = charge_of(self.term, x, step)
        return None if inner is None else lambda corners, windows: self.factor * inner(corners, windows)

    def place_charge(self, exemplar: Exemplar, shape: tuple[int, ...], width: tuple[int, ...]) -> PlaceCharge | None:
        """The factor times the inner term's charge."""
        inner = place_charge_of(self.term, exemplar, shape, width)
        return None if inner is None else lambda corners, there: self.factor * inner(corners, there)

    def energy(self, x: Tensor) -> float:
        """The factor times the inner term's energy."""
        return self.factor * self.term.energy(x)

    def quadratic(self, x: Tensor) -> Quadratic:
        """The inner quadratic with lambda F scaled."""
        scaled = self.term.quadratic(x).scaled(self.factor)
        return scaled if self.factor > 0 else replace(scaled, fixed=None)


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
    if isinstance(terms, Sequence) and not isinstance(terms, str):
        return tuple(part for item in terms for part in parts_of(item))
    missing = [member for member in ("name", "at", "energy", "quadratic") if not hasattr(terms, member)]
    if missing:
        raise InputError(
            f"{type(terms).__name__} is not a term, it has no {', '.join(missing)}; see kwatra.TermLike for what a "
            "term offers"
        )
    return (terms,)


def charge_of(term: TermLike, x: Tensor | None, step: "Step") -> Charge | None:
    """What the term charges candidates, None where it leaves that to its quadratic (see `Term.charge`).

    The charge raises InputError where the term answers with anything but a number for each candidate.
    """
    charge: Charge | None = term.charge(x, step) if hasattr(term, "charge") else None
    return None if charge is None else partial(_charged, term.name, charge, 1)


def place_charge_of(
    term: TermLike, exemplar: Exemplar, shape: tuple[int, ...], width: tuple[int, ...]
) -> PlaceCharge | None:
    """What the term charges for places, None for nothing (see `Term.place_charge`). Raises as that of `charge_of`."""
    charge: PlaceCharge | None = term.place_charge(exemplar, shape, width) if hasattr(term, "place_charge") else None
    return None if charge is None else partial(_charged, term.name, charge, 2)


def _charged(name: str, charge: Charge, axes: int, corners: Tensor, there: Tensor) -> Tensor:
    """What a term charges for candidates, of which the first `axes` of `there` say how many there are."""
    cost, asked, wrong = charge(corners, there), tuple(there.shape[:axes]), ""
    if not isinstance(cost, Tensor):
        wrong = f"a {type(cost).__name__}"
    elif cost.shape != asked:
        wrong = f"a tensor {tuple(cost.shape)}"
    elif bool(cost.isnan().any()):
        wrong = "NaN"
    if wrong:
        raise InputError(
            f"the term {name!r} charges {wrong} for candidates {tuple(there.shape)}; its charge returns a tensor "
            f"{asked} of numbers"
        )
    return cost


def within(term: TermLike, mask: Tensor) -> TermLike:
    """The term without what it wants behind the mask, where it has a say in that (see `Term.within`)."""
    return term.within(mask) if hasattr(term, "within") else term
