"""What belongs somewhere stays there: a flame's base, a horizon, the banks of a stream.

A window prefers exemplar windows from its own place in the frame. Places are shares of the frame, 0 at its first pixel
and 1 at its last, so that an output of another size is the same scene at that size; in a larger one what changes from
place to place keeps its size, and what is alike fills the rest (`grown`). What a window costs grows with the square of
the distance; distances along time are none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.elements import grown
from kwatra.exemplar import Exemplar
from kwatra.terms.algebra import PlaceCharge, Quadratic, Term, TermLike

STAYING = 0.3
"""The weight of staying where it is decided from the exemplar, chosen on a waterfall: with 1 more is replayed."""

SCENE = 0.5
"""From this dependence on the place on a clip is a scene: clips of water, fire, smoke and fish have .75 to 1."""

REACH = 0.25
"""From this share of the frame away a window costs the term's weight, in variances of the exemplar: what the weight is
meant by, so that only STAYING was chosen."""


@dataclass(frozen=True)
class Stay(Term):
    """Windows prefer their own place: one from a quarter of the frame away costs `weight` times the texture's variance.

    weight: >= 0 and finite. Needs a texture that is an exemplar. Its variants (mirrored, turned, scaled) have the
    places of the pixels that they are made of.
    """

    weight: float

    def __post_init__(self) -> None:
        if not (0 <= self.weight < float("inf")):
            raise InputError(f"the weight of staying is {self.weight}; it is finite and >= 0")

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return "stay"

    def at(self, factor: tuple[int, ...], shape: tuple[int, ...]) -> TermLike:
        """The same: places are shares of the frame."""
        return self

    def quadratic(self, x: Tensor) -> Quadratic:
        """Nothing is wanted of pixels."""
        nothing = torch.zeros_like(x[:1])
        return Quadratic(nothing, nothing)

    def place_charge(self, exemplar: Exemplar, shape: tuple[int, ...], width: tuple[int, ...]) -> PlaceCharge | None:
        """See `Term.place_charge`."""
        if self.weight == 0:
            return None
        places = _places(exemplar, shape)
        middle = torch.tensor(width, device=places.device) // 2
        size = torch.tensor(shape[-2:], device=places.device) - 1
        last = torch.tensor(exemplar.shape, device=places.device) - 1
        scale = self.weight * exemplar.variance / REACH**2

        def charge(corners: Tensor, there: Tensor) -> Tensor:
            own = (corners + middle)[..., -2:].float() / size.clamp(min=1)
            at = torch.minimum(there + middle, last).unbind(-1)  # in outputs that wrap blocks may be smaller
            theirs = torch.stack([place[tuple(at)] for place in places], -1)
            return scale * (theirs - own[:, None]).square().sum(-1)

        return charge


def _places(exemplar: Exemplar, shape: Sequence[int]) -> Tensor:
    """For each pixel of the canvas where it belongs in an output's frame (*S): (2, *S), row and column as shares."""
    places = torch.zeros(2, *exemplar.shape, dtype=torch.float32, device=exemplar.canvas.device)
    larger = [there / here for there, here in zip(shape[-2:], exemplar.extent[-2:], strict=True)]
    for image in exemplar.origin[0][exemplar.owner >= 0].unique().tolist():
        inside = (exemplar.origin[0] == image) & (exemplar.owner >= 0)
        time, place = exemplar.origin[1:-2, inside], exemplar.origin[-2:, inside].float()
        low, high = place.amin(1, keepdim=True), place.amax(1, keepdim=True)
        late = time[0] > int(time.amax()) // 2 if len(time) else None
        colors = exemplar.canvas[:, inside]
        for axis, share in enumerate((place - low) / (high - low).clamp(min=1)):
            places[axis, inside] = grown(share, colors, late, larger[axis])
    return places
