"""The M-step on a whole grid: for every window of an image the exemplar window that explains it best.

A window is compared with what is asked of it (thesis equation 26): likeness on its unmasked pixels, closeness of the
source window to what the terms wish for, and what terms charge for it (equation 31). Candidates come from the index and
from coherence (the match a window had, and those of its neighbors, shifted; only where windows have places); the most
promising are compared exactly. Windows without a free pixel are skipped. Windows of which a term wants something keep
asking the index even where others go by coherence alone: what suits the term is not among their neighbors.

Fixed pixels take part in choosing a match, not in weighing it against others: the robust weights look at what the
blend can change. Else where much is fixed every window would seem equally bad, and their mean a blur.

A partly masked window has no descriptor. Its missing pixels are filled in from the match it has, which majorizes the
masked distance: what is nearer than this match to the filled window is nearer on the unmasked pixels too. Without a
match their expected values given the others are taken (`Source.completed`). The filled window is described,
and more candidates than usual are compared on the unmasked pixels alone.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor

from kwatra.base import even_ranges, shared
from kwatra.source import CHUNK, Description, Source, SourceWindows
from kwatra.steps.asked import Asked, Wants
from kwatra.steps.coherent import coherent, nearest_coherent
from kwatra.steps.inplace import fits, nearest_in_place
from kwatra.steps.votes import bands
from kwatra.terms import Given
from kwatra.windows import Grid, Layout, channels_last, windows_at
from kwatra.windows.flat import continued

SETTLED = 1e-7
"""Squared distance (mean over a window, colors in [0, 1]) up to which a match counts as a verbatim copy: rounding."""

CANDIDATES = 3
"""How many matches are compared exactly; ten guided images score the same with 2, and follow their guide alike."""

PARTIAL = 4
"""So many times more candidates are compared where the descriptor is a guess: for partly masked windows, and where
terms charge for what no descriptor tells."""

TOGETHER = 2**15
"""Where all coherent candidates are looked at, as places are charged for or windows are free, about so many windows do
at a time: where those lie takes a few megabytes then, whatever the output's size, and threads share the parts. Not
tuned. Two threads took .26 s for two searches of 2048x2048, and .36 s where only the comparing was shared."""

DRAWN = 32
"""So many windows are drawn for each place where terms alone decide; tuned on nothing, cost grows with it."""


@dataclass(frozen=True)
class Found:
    """The matches (N,) of all windows, their squared distances (N,) as a mean over the unmasked pixels, and the same
    over the free values alone, which weighs them. Windows without a free pixel have distances of 0.
    """

    matches: Tensor
    squared: Tensor
    free: Tensor


class Matching:
    """Finds the matches of all windows of a layout; `given` says which pixels are masked or fixed."""

    def __init__(self, source: Source, layout: Layout, given: Given | None) -> None:
        self.source, self.layout = source, layout
        self.mask = None if given is None else given.mask
        self.free = None if given is None else (~given.fixed).float()
        self.active = None if given is None else self._any(given.free)

    def _any(self, pixels: Tensor) -> Tensor:
        """Which windows (N,) hold any of these pixels (1, *S)."""
        parts = [band.gather(pixels.float()).flatten(1).any(1) for _, band in bands(self.layout, self.source.metric)]
        return torch.cat(parts)

    def best(self, image: Tensor, matches: Tensor | None, wants: Wants, route: str, asks: bool = True) -> Found:
        """The best match of every window; `matches` are those of the last iteration, if any.

        asks: on the coherent route, whether windows of which terms want something ask the index as well.
        """
        if self.mask is None and wants.wish is None and not wants.charges and fits(self.source):
            return self._plain(self.source, image, matches, wants, route)
        found, distances, free = [], [], []
        for part, band in bands(self.layout, self.source.metric):
            asked = Asked.of(band, image, wants, self.mask)
            near = None if matches is None else coherent(self.layout, self.source, matches, part)
            active = None if self.active is None else self.active[part]
            number, squared = self._matched(asked, wants, near, active, route, asks)
            found.append(number)
            distances.append(squared)
            free.append(squared if self.free is None else self._apart(asked.windows, number, band.gather(self.free)))
        return Found(torch.cat(found), torch.cat(distances), torch.cat(free))

    def _plain(self, source: SourceWindows, image: Tensor, matches: Tensor | None, wants: Wants, route: str) -> Found:
        """As `best`, where colors and places are all there is to compare: windows stay where they are."""
        pixels, corners = continued(channels_last(image), self.layout), self.layout.corners
        if matches is None:
            number = source.numbers[:1].expand(len(corners)).clone()
            squared = torch.full((len(corners),), torch.inf, dtype=torch.float32)
        else:
            number, squared = self._nearest_coherent(source, pixels, matches, wants)
        if route != "coherent":
            open_, k = squared > SETTLED, CANDIDATES * (PARTIAL if wants.places else 1)
            open_ = open_ if self.active is None else open_ & self.active
            for pick in open_.nonzero()[:, 0].split(max(CHUNK // source.metric.weight.numel(), 1)):
                windows = windows_at(pixels, corners[pick], source.width)
                found = source.nearest(source.describe(windows), k, route)
                near = found if matches is None else torch.cat([number[pick, None], found], 1)
                away = wants.away(corners[pick], source, near)
                number[pick], squared[pick] = nearest_in_place(pixels, corners[pick], source, near, away=away)
        if self.active is None or self.free is None:
            return Found(number, squared, squared)
        squared = torch.where(self.active, squared, 0.0)  # nothing was looked for, which leaves infinity
        return Found(number, squared, self._freed(self.free, image, number, squared))

    def _nearest_coherent(
        self, source: SourceWindows, pixels: Tensor, matches: Tensor, wants: Wants
    ) -> tuple[Tensor, Tensor]:
        """The nearest coherent candidate of every window (N,), and its squared distance (N,).

        pixels: the image, channels last and `continued`.
        """
        if not wants.places and isinstance(self.layout, Grid):
            return nearest_coherent(pixels, self.layout, source, matches, SETTLED)
        windows = self.layout.corners

        def nearest(part: slice) -> tuple[Tensor, Tensor]:
            corners, candidates = windows[part], coherent(self.layout, source, matches, part)
            away = wants.away(corners, source, candidates)
            return nearest_in_place(pixels, corners, source, candidates, SETTLED, away)

        parts = even_ranges(len(windows), -(-len(windows) // TOGETHER))
        found = shared(nearest, [slice(*part) for part in parts])
        return torch.cat([number for number, _ in found]), torch.cat([squared for _, squared in found])

    def _freed(self, pixels: Tensor, image: Tensor, number: Tensor, squared: Tensor) -> Tensor:
        """Squared distances (N,) over the free `pixels` alone, of windows whose distances over all are `squared`."""
        freed = squared.clone()
        for part, band in bands(self.layout, self.source.metric):
            free = band.gather(pixels)
            some = (free < 1).flatten(1).any(1) & (squared[part] > 0)
            freed[part][some] = self._apart(band.gather(image)[some], number[part][some], free[some])
        return freed

    def by_terms(self, wants: Wants, blank: Tensor, generator: torch.Generator) -> Tensor:
        """Matches (N,) that please the terms alone, whatever they look like (thesis 7.1, initialization).

        blank (C, *S): an image, for its size. Candidates are drawn at random, beside those nearest to what is wished.
        """
        found = []
        for _, band in bands(self.layout, self.source.metric):
            asked = Asked.of(band, blank, wants, self.mask)
            pick = torch.randint(len(self.source.numbers), (len(band), DRAWN), generator=generator)
            candidates = self.source.numbers[pick.to(self.source.numbers.device)]
            if asked.weight is not None and asked.value is not None:
                present = (asked.weight > 0).any(-1, keepdim=True).float()
                wished = self.source.describe(self.source.completed(asked.value, present))
                candidates = torch.cat([self.source.nearest(wished, CANDIDATES, "approximate"), candidates], 1)
            number, _ = cheapest(self.source, candidates, partial(asked.pleasing, self.source.metric))
            found.append(number)
        return torch.cat(found)

    def _apart(self, windows: Tensor, number: Tensor, free: Tensor) -> Tensor:
        """Squared distances (N,) of windows to their matches over the values where `free` (N, *width, C) is 1."""
        metric = self.source.metric
        share = (metric.weight * free).flatten(1).sum(1)
        return metric.squared(free * (windows - self.source.windows(number))) / share.clamp(min=1e-12)

    def _matched(
        self, asked: Asked, wants: Wants, near: Tensor | None, active: Tensor | None, route: str, asks: bool
    ) -> tuple[Tensor, Tensor]:
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
            open_ = (squared > SETTLED) | asked.wanted
        if active is not None:
            squared, open_ = squared * active, open_ & active
        pick = open_.nonzero()[:, 0]
        if len(pick):
            asked, near = asked[pick], None if near is None else near[pick]
            candidates = self._candidates(asked, wants, near, route, asks)
            away = wants.away(asked.corners, self.source, candidates)
            cost = partial(asked.cost, self.source.metric)
            number[pick], squared[pick] = cheapest(self.source, candidates, cost, away)
        return number, squared

    def _candidates(self, asked: Asked, wants: Wants, near: Tensor | None, route: str, asks: bool) -> Tensor:
        """The most promising matches (N, k) of windows: the one they have first, then those estimated nearest."""
        k = CANDIDATES * (1 if self.mask is None and not asked.charges and not wants.places else PARTIAL)
        described = self.source.describe(asked.target(self.source, None if near is None else near[:, 0]))
        if near is None:
            rest = self.source.nearest(described, k, route)
        elif route == "coherent":
            rest = near[:, 1:]
            if asks and bool((wanted := asked.wanted).any()):
                rest = torch.cat([rest, self._asked_for(described, wanted, near[:, :1], k)], 1)
        else:
            rest = torch.cat([near[:, 1:], self.source.nearest(described, k, route)], 1)
        estimate, away = self.source.estimate(described, rest), wants.away(asked.corners, self.source, rest)
        order = (estimate if away is None else estimate + away).argsort(dim=1, stable=True)[:, :k]
        rest = rest.gather(1, order)
        return rest if near is None else torch.cat([near[:, :1], rest], 1)

    def _asked_for(self, described: Description, wanted: Tensor, own: Tensor, k: int) -> Tensor:
        """What the index has for the windows `wanted` (N,), (N, <= k); for the others their `own` (N, 1) match."""
        found = self.source.nearest(Description(*(part[wanted] for part in described)), k, "approximate")
        columns = own.expand(-1, found.shape[1]).clone()
        columns[wanted] = found
        return columns


def cheapest(
    source: Source,
    candidates: Tensor,
    cost: Callable[[Tensor], tuple[Tensor, Tensor]],
    away: Tensor | None = None,
) -> tuple[Tensor, Tensor]:
    """Choose among candidates (N, k) by exact cost; the first of equals wins.

    `cost` maps source windows (N, *width, C) to what is compared (N,) and to squared distances (N,). away (N, k): what
    candidates cost besides. Returns the chosen numbers (N,) and their squared distances (N,).
    """
    best = candidates[:, 0]
    least, distance = cost(source.windows(best))
    if away is not None:
        least = least + away[:, 0]
    for number, column in enumerate(candidates.T[1:], 1):
        c, d = cost(source.windows(column))
        c = c if away is None else c + away[:, number]
        better = c < least
        best = torch.where(better, column, best)
        distance = torch.where(better, d, distance)
        least = torch.where(better, c, least)
    return best, distance
