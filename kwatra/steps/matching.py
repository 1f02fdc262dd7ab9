"""The M-step on a whole grid: for every window of an image the exemplar window that explains it best.

A window is compared with what is asked of it (thesis equation 26): likeness on its unmasked pixels, and closeness of
the exemplar window to what the terms wish for. Candidates come from the index and from coherence (the match a window
had, and those of its grid neighbors, shifted); the most promising are compared exactly. Windows without a free pixel
are skipped.

Fixed pixels take part in choosing a match, not in weighing it against others: the robust weights look at what the
blend can change. Else where much is fixed every window would seem equally bad, and their mean a blur.

A partly masked window has no descriptor. Its missing pixels are filled in from the match it has, which majorizes the
masked distance: what is nearer than this match to the filled window is nearer on the unmasked pixels too. Without a
match their expected values given the others are taken (`SourceWindows.completed`). The filled window is described,
and more candidates than usual are compared on the unmasked pixels alone.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.source import SourceWindows, cheapest
from kwatra.steps.blend import bands
from kwatra.terms import Given, Wish
from kwatra.windows import Grid, Metric

SETTLED = 1e-7
"""Squared distance (mean over a window, colors in [0, 1]) up to which a match counts as a verbatim copy."""

PARTIAL = 4
"""So many times more candidates are compared for a partly masked window, whose descriptor is a guess."""


@dataclass(frozen=True)
class Asked:
    """What is asked of the matches of some windows.

    windows (N, *width, C): to be like these; present (N, *width, 1) of 0 and 1, or None: at these pixels. weight and
    value (N, *width, C): what terms wish for, or None.
    """

    windows: Tensor
    present: Tensor | None
    weight: Tensor | None
    value: Tensor | None

    @classmethod
    def of(cls, grid: Grid, image: Tensor, wish: Wish | None, mask: Tensor | None) -> "Asked":
        """What is asked of the windows of a grid; wish and mask (1, *S) as images."""
        present = None if mask is None else grid.gather(mask.float())
        if wish is None:
            return cls(grid.gather(image), present, None, None)
        return cls(grid.gather(image), present, grid.gather(wish.weight), grid.gather(wish.value))

    def __getitem__(self, pick: Tensor) -> "Asked":
        """Some of the windows."""
        parts = (self.present, self.weight, self.value)
        return Asked(self.windows[pick], *(None if part is None else part[pick] for part in parts))

    def squared(self, metric: Metric, there: Tensor) -> Tensor:
        """Squared distances (N,) to exemplar windows (N, *width, C): a mean over the unmasked pixels."""
        if self.present is None:
            return metric.squared(self.windows - there)
        return metric.squared(self.present * (self.windows - there)) / self._share(metric)

    def cost(self, metric: Metric, there: Tensor) -> tuple[Tensor, Tensor]:
        """What exemplar windows (N, *width, C) cost with the wish (thesis equation 26), and squared distances (N,).

        The wish counts by the same falloff as likeness: so much does a window contribute to a pixel.
        """
        squared = self.squared(metric, there)
        if self.weight is None or self.value is None:
            return squared, squared
        wish = (metric.weight * self.weight * (there - self.value) ** 2).flatten(1).sum(1)
        return squared + wish / self._share(metric), squared

    def _share(self, metric: Metric) -> Tensor:
        """The part (N,) of each window that is not masked, by weight."""
        if self.present is None:
            return metric.weight.new_ones(())
        return (metric.falloff * self.present).flatten(1).sum(1).clamp(min=1e-12)

    def target(self, source: SourceWindows, matches: Tensor | None) -> Tensor:
        """The windows (N, *width, C) to look for.

        With a wish (w, c) that is (x + w c) / (1 + w), where the sum of both distances is least; what is masked is
        filled in from the `matches` (N,), if any, or by expectation.
        """
        wanted = self.windows
        if self.weight is not None and self.value is not None:
            wanted = (wanted + self.weight * self.value) / (1 + self.weight)
        if self.present is None:
            return wanted
        if matches is not None:
            return torch.where(self.present > 0, wanted, source.windows(matches))
        partial = (self.present == 0).flatten(1).any(1)
        if bool(partial.any()):
            wanted = wanted.clone()
            wanted[partial] = source.completed(wanted[partial], self.present[partial])
        return wanted


@dataclass(frozen=True)
class Found:
    """The matches (N,) of all windows, their squared distances (N,) as a mean over the unmasked pixels, and the same
    over the free values alone, which weighs them. Windows without a free pixel have distances of 0.
    """

    matches: Tensor
    squared: Tensor
    free: Tensor


class Matching:
    """Finds the matches of all windows of a grid; `given` says which pixels are masked or fixed."""

    def __init__(self, source: SourceWindows, grid: Grid, candidates: int, given: Given | None) -> None:
        self.source, self.grid, self.candidates = source, grid, candidates
        self.mask = None if given is None else given.mask
        self.free = None if given is None else (~given.fixed).float()
        self.active = None if given is None else self._any(given.free)

    def _any(self, pixels: Tensor) -> Tensor:
        """Which windows (N,) hold any of these pixels (1, *S)."""
        parts = [band.gather(pixels.float()).flatten(1).any(1) for _, band in bands(self.grid, self.source.metric)]
        return torch.cat(parts)

    def best(self, image: Tensor, matches: Tensor | None, wish: Wish | None, route: str) -> Found:
        """The best match of every window; `matches` are those of the last iteration, if any."""
        coherent = None if matches is None else self._coherent(matches)
        found, distances, free = [], [], []
        for part, band in bands(self.grid, self.source.metric):
            asked = Asked.of(band, image, wish, self.mask)
            near = None if coherent is None else coherent[part]
            number, squared = self._matched(asked, near, None if self.active is None else self.active[part], route)
            found.append(number)
            distances.append(squared)
            free.append(squared if self.free is None else self._free(asked, number, band.gather(self.free)))
        return Found(torch.cat(found), torch.cat(distances), torch.cat(free))

    def _free(self, asked: Asked, number: Tensor, free: Tensor) -> Tensor:
        """Squared distances (N,) of windows to their matches over the values where `free` (N, *width, C) is 1."""
        metric = self.source.metric
        share = (metric.weight * free).flatten(1).sum(1)
        return metric.squared(free * (asked.windows - self.source.windows(number))) / share.clamp(min=1e-12)

    def _matched(self, asked: Asked, near: Tensor | None, active: Tensor | None, route: str) -> tuple[Tensor, Tensor]:
        """Best matches of the windows and their squared distances; `near` are coherent candidates.

        Windows that match without cost are not searched for.
        """
        if near is None:
            number = self.source.numbers[:1].expand(len(asked.windows)).clone()
            squared = asked.windows.new_zeros(len(number))
            open_ = torch.ones_like(squared, dtype=torch.bool)
        else:
            number = near[:, 0].clone()
            squared = asked.squared(self.source.metric, self.source.windows(number))
            open_ = squared > SETTLED
            if asked.weight is not None:
                open_ |= (asked.weight > 0).flatten(1).any(1)
        if active is not None:
            squared, open_ = squared * active, open_ & active
        pick = open_.nonzero()[:, 0]
        if len(pick):
            asked, near = asked[pick], None if near is None else near[pick]
            candidates = self._candidates(asked, near, route)
            number[pick], squared[pick] = cheapest(
                self.source, candidates, lambda there: asked.cost(self.source.metric, there)
            )
        return number, squared

    def _coherent(self, matches: Tensor) -> Tensor:
        """Each window's match and its grid neighbors' matches, shifted: (N, 1 + 2n)."""
        columns = [matches]
        corners = self.source.corners(matches)
        for neighbor, shift in self.grid.neighbor_shifts():
            columns.append(self.source.snapped(corners[neighbor] + shift))
        return torch.stack(columns, 1)

    def _candidates(self, asked: Asked, near: Tensor | None, route: str) -> Tensor:
        """The most promising matches (N, k) of windows: the one they have first, then those estimated nearest."""
        k = self.candidates * (1 if self.mask is None else PARTIAL)
        described = self.source.describe(asked.target(self.source, None if near is None else near[:, 0]))
        if near is None:
            rest = self.source.nearest(described[0], k, route)
        elif route == "coherent":
            rest = near[:, 1:]
        else:
            rest = torch.cat([near[:, 1:], self.source.nearest(described[0], k, route)], 1)
        order = self.source.estimate(*described, rest).argsort(dim=1, stable=True)[:, :k]
        rest = rest.gather(1, order)
        return rest if near is None else torch.cat([near[:, :1], rest], 1)
