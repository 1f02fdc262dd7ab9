"""A vote by minimum cuts: every pixel copies one of the windows that cover it, so that seams between copies show least.

Minimizes, over the choice of a window for every pixel,

    sum_p likeness |z(p) - mean(p)|  +  sum over neighbors p, q of M(p, q, A, B),

where the mean is what all windows say and M the cost of a seam between the copies A and B (thesis equation 1). It
begins with the window that weighs most and goes through the others, those that do not overlap at once: each is laid
over what stands along a minimum cut (thesis 3.1), so the sum never rises.
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.cut import FREE, KEEP, best_cut
from kwatra.pieces import Mosaic, SeamCost
from kwatra.pieces.seams import beside, summed
from kwatra.source import SourceWindows, heaviest_covering
from kwatra.steps.votes import Ballot, Pull, mean


@dataclass(frozen=True)
class CheapestSeams:
    """Copies along minimum cuts pull, with the mass of all.

    likeness >= 0: what a pixel's difference from the mean counts against that of a seam through it. Only windows of an
    exemplar have copies to cut: InputError for others. Memory: some ten integers per pixel.
    """

    likeness: float = 0.5

    def __post_init__(self) -> None:
        if not (0 <= self.likeness < float("inf")):
            raise InputError(f"likeness is {self.likeness}; it is finite and >= 0")

    def __call__(self, ballot: Ballot) -> Pull:
        """The vote."""
        if not isinstance(ballot.source, SourceWindows):
            raise InputError("seams run between copies of an exemplar, but windows come from none; vote by mean")
        source, (middle, mass) = ballot.source, mean(ballot)
        labels = _Labels(source, middle, self.likeness)
        heaviest = heaviest_covering(ballot.layout, source.metric, ballot.weights)
        places = labels.of(ballot, heaviest.window, list(heaviest.place))
        for window, inside, there in ballot.layout.coverings():
            window, there, *inside = torch.broadcast_tensors(window, there, *inside)
            choice = _inner(window.cpu().numpy(), there.cpu().numpy())
            places = labels.laid(places, labels.of(ballot, window, list(inside)), choice)
        where = labels.mosaic.coordinates(places)[1]
        image = source.exemplar.canvas[(slice(None), *torch.from_numpy(where).long().to(mass.device))]
        return Pull(image, mass)


class _Labels:
    """Source places as labels of pixels, and what a labeling costs."""

    def __init__(self, source: SourceWindows, middle: Tensor, likeness: float) -> None:
        share = source.exemplar.share
        self.source, self.likeness = source, likeness
        self.mosaic = Mosaic([(source.exemplar.canvas * share).cpu().numpy()])
        self.cost = SeamCost(self.mosaic)
        self.middle = ((middle * share).cpu().numpy() - self.mosaic.low) / self.mosaic.step

    def of(self, ballot: Ballot, window: Tensor, inside: list[Tensor]) -> np.ndarray:
        """The places (*S) that windows (*S) show at the places `inside` them."""
        corners = self.source.corners(ballot.matches[window.flatten()]).T.view(-1, *window.shape)
        return self.mosaic.places_of([(c + i).cpu().numpy() for c, i in zip(corners, inside, strict=True)])

    def unlike(self, places: np.ndarray) -> np.ndarray:
        """What likeness to the mean costs each pixel, in the units of seams."""
        return np.rint(self.likeness * np.abs(self.mosaic.colors(places) - self.middle).sum(0)).astype(np.int64)

    def price(self, places: np.ndarray) -> int:
        """What is minimized."""
        return int(self.unlike(places).sum()) + summed(self.cost.within(places))

    def laid(self, old: np.ndarray, new: np.ndarray, choice: np.ndarray) -> np.ndarray:
        """The cheapest of old and new places, taken together where `choice` leaves it free."""
        pairs = self.cost.pairs(old, new, self.cost.within(old))
        take = best_cut(choice, pairs, self.unlike(new) - self.unlike(old))
        return np.where(take, new, old)


def _inner(window: np.ndarray, there: np.ndarray) -> np.ndarray:
    """FREE inside of windows (*S), by number; KEEP along their rims, where two meet: each is a patch of its own."""
    rim = ~there
    for axis in range(window.ndim):
        p, q = beside(axis, window.ndim)
        meet = window[p] != window[q]
        rim[p] |= meet
        rim[q] |= meet
    return np.where(rim, KEEP, FREE)
