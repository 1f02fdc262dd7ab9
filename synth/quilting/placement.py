"""The offset that suits a region (thesis section 3.2), drawn from those that cover it and have not been used,

    P(t) ~ exp(-C(t) / (k sigma^2))      (equation 3),

C by whole or sub-patch matching (matching.py), or 0 for random placement; sigma^2 the variance of the exemplar.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch

from kwatra.pieces.boxes import Box, everywhere
from kwatra.pieces.seams import Mosaic
from kwatra.pieces.sheet import Patch, Regions, Sheet
from synth.quilting.borders import admitted, homely, margins, trimmed
from synth.quilting.folds import folded
from synth.quilting.matching import Matcher
from synth.quilting.usage import Usage

FOLD = 100.0
"""Added to C, in units of sigma^2, where a mirrored copy would fold the picture: any other offset is better."""


@dataclass(frozen=True)
class Rule:
    """How offsets are chosen.

    `kind`: "random", "whole" or "sub". `k`: equation 3. `region`: extent of the error-region per axis.
    `evenness`: what a source region used on average as often as any other adds to C, in units of sigma^2.
    `most`: the most pixels a patch may have (bounds memory and time of a cut).
    `reach`: how far a patch may reach past the region on each side, in extents of the region. Larger patches make fewer
    seams, and copy larger pieces.
    `margin`: how far from its source's border a patch ends, per axis, and `inside`: see borders.py.
    `drift`: how long offsets may be, per axis, where the region allows it; see borders.py.
    `apart`: offsets are unused if on some axis they differ by so much from each one that was used.
    """

    kind: str
    k: float
    region: tuple[int, ...]
    evenness: float = 0.0
    most: int = 1_500_000
    reach: float = 1.0
    margin: tuple[int, ...] | None = None
    inside: bool = False
    drift: tuple[int, ...] | None = None
    apart: tuple[int, ...] | None = None


class Placer:
    """Chooses patches for the regions of a sheet; remembers the offsets it has used."""

    def __init__(self, sheet: Sheet[Mosaic], rule: Rule, generator: torch.Generator):
        self.sheet, self.rule, self.generator = sheet, rule, generator
        self.matcher = Matcher(sheet)
        self.used: set[tuple[int, tuple[int, ...]]] = set()
        self.regions = Regions(sheet, rule.region, generator)
        self._used: Usage | None = None

    def choose(self, region: Box, *, grid: tuple[int, ...] | None = None, filling: bool = False) -> Patch | None:
        """A patch that covers `region`, drawn by equation 3 among the unused offsets; None if there is none.

        `grid`: only offsets that are multiples of it, if there are any.
        """
        spans, costs = [], []
        usage = self._usage()
        for number in range(len(self.sheet.sources.shapes)):
            span = self._allowed(number, region)
            if span is None:
                continue
            cost = self._cost(number, region, filling, usage)
            cost[self._folds(number, region, span)] += FOLD
            cost[self._taken(number, span) | ~self._admitted(number, region, span)] = np.inf
            spans.append((number, span))
            costs.append(cost)
        if grid is not None:
            on_grid = [
                np.where(_multiples(span, grid), cost, np.inf) for (_, span), cost in zip(spans, costs, strict=True)
            ]
            if any(np.isfinite(c).any() for c in on_grid):
                costs = on_grid
        pick = self._draw(np.concatenate([c.ravel() for c in costs]) if costs else np.empty(0))
        if pick is None:
            return None
        for (number, span), cost in zip(spans, costs, strict=True):
            if pick < cost.size:
                shift = np.add(np.unravel_index(pick, cost.shape), span.start)
                return self._patch(number, tuple(int(s) for s in shift), region)
            pick -= cost.size
        raise AssertionError("a draw lies within the costs it was drawn from")

    def _allowed(self, number: int, region: Box) -> Box | None:
        bands = self.sheet.sources.bands
        if bands is not None:
            low, high = self._band(number)
            if region.start[-2] < low or region.stop[-2] > high:
                return None
        return self.matcher.translations(number, region)

    def _band(self, number: int) -> tuple[int, int]:
        assert self.sheet.sources.bands is not None
        low, high = self.sheet.sources.bands[number]
        return round(low * self.sheet.shape[-2]), round(high * self.sheet.shape[-2])

    def _cost(self, number: int, region: Box, filling: bool, usage: list[np.ndarray] | None) -> np.ndarray:
        """C of equation 3, in units of sigma^2."""
        if self.rule.kind == "random" or not self.sheet.patches:
            span = self.matcher.translations(number, region)
            assert span is not None
            cost = np.zeros(span.extent)
        else:
            match = self.matcher.whole if self.rule.kind == "whole" else self.matcher.sub
            cost = match(number, region) / max(self.sheet.sources.variance, 1e-12)
        if usage is not None:
            cost = cost + self.rule.evenness * self.matcher.mean_usage(number, region, usage[number], filling)
        return cost

    def _usage(self) -> list[np.ndarray] | None:
        if self.rule.evenness <= 0 or self.rule.kind == "random" or not self.sheet.patches:
            return None
        if self._used is None:
            self._used = Usage(self.sheet)
        return self._used.relative()

    def _folds(self, number: int, region: Box, span: Box) -> np.ndarray:
        """Translations that would fold the picture along half the error-region's shorter side, or more."""
        if not self.sheet.patches or not self.sheet.sources.mirrored(number):
            return np.zeros(span.extent, bool)
        long = np.prod(region.extent) / max(region.extent[-2:]) / 2
        return folded(self.sheet, number, span, self.matcher.reach(number, region)) >= long

    def _margin(self, number: int, region: Box) -> tuple[int, ...]:
        wanted = self.rule.margin or (0,) * len(region.extent)
        return margins(self.sheet.sources.shapes[number], region.extent, wanted)

    def _admitted(self, number: int, region: Box, span: Box) -> np.ndarray:
        sheet, margin = self.sheet, self._margin(number, region)
        source = sheet.sources.shapes[number]
        fits = admitted(span, source, region, sheet.shape, sheet.periodic, margin, self.rule.inside)
        return fits if self.rule.drift is None else fits & homely(span, self.rule.drift)

    def _taken(self, number: int, span: Box) -> np.ndarray:
        mask = np.zeros(span.extent, bool)
        periods = [n if wraps else 0 for n, wraps in zip(self.sheet.shape, self.sheet.periodic, strict=True)]
        apart = self.rule.apart or (1,) * len(periods)
        used = np.array([shift for home, shift in self.used if home == number]).reshape(-1, len(periods))
        near = np.ones(len(used), bool)
        for line, low, high, n, a in zip(used.T, span.start, span.stop, periods, apart, strict=True):
            near &= (n > 0) | (low - a < line) & (line < high - 1 + a)
        for shift in used[near]:
            lines = zip(shift, span.start, span.stop, periods, apart, strict=True)
            mask[np.ix_(*[_near(*line) for line in lines])] = True
        return mask

    def _draw(self, cost: np.ndarray) -> int | None:
        if not np.isfinite(cost).any():
            return None
        if self.rule.kind == "random":
            weight = (cost == cost.min()).astype(np.float64)
        else:
            weight = np.exp(-(cost - cost.min()) / self.rule.k)
        total = np.cumsum(weight)
        draw = float(torch.rand(1, generator=self.generator, dtype=torch.float64)) * total[-1]
        return int(min(np.searchsorted(total, draw, side="right"), len(cost) - 1))

    def _patch(self, number: int, shift: tuple[int, ...], region: Box) -> Patch:
        self.used.add((number, shift))
        shape = self.sheet.sources.shapes[number]
        sheet = self.sheet
        box = trimmed(Box(shift, shape), sheet.shape, sheet.periodic, self._margin(number, region))
        box = box.clipped(sheet.shape, sheet.periodic)
        if self.sheet.sources.bands is not None:
            low, high = self._band(number)
            start, stop = max(box.start[-2], low), min(box.stop[-2], high)
            box = Box((*box.start[:-2], start, box.start[-1]), (*box.extent[:-2], stop - start, box.extent[-1]))
        return Patch(number, shift, self._bounded(box, region))

    def _bounded(self, box: Box, region: Box) -> Box:
        """`box` cut, around `region`, to what the sheet, the budget of a cut and the rule's reach allow."""
        wide = [math.ceil(e * (1 + 2 * self.rule.reach)) for e in region.extent]
        excess = max(np.prod(box.extent, dtype=float) / self.rule.most, 1.0)
        shrink = excess ** (-1 / len(box.extent))
        start, extent = [], []
        for d, (s, e, rs, re) in enumerate(zip(box.start, box.extent, region.start, region.extent, strict=True)):
            length = min(max(int(e * shrink), re), e, wide[d], self.sheet.longest(d))
            start.append(int(np.clip(rs + (re - length) // 2, s, s + e - length)))
            extent.append(length)
        return Box(tuple(start), tuple(extent))


def _multiples(span: Box, grid: tuple[int, ...]) -> np.ndarray:
    hits = [np.arange(a, b) % g == 0 for a, b, g in zip(span.start, span.stop, grid, strict=True)]
    return everywhere(hits)


def _near(shift: int, low: int, high: int, period: int, apart: int) -> np.ndarray:
    """Positions in `low..high` less than `apart` from `shift`, on an axis that wraps modulo its `period`."""
    gap = np.abs(np.arange(low, high) - shift)
    return np.flatnonzero((np.minimum(gap % period, -gap % period) if period else gap) < apart)
