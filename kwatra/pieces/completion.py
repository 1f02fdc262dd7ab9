"""Elements that the border of what is given cuts: each is completed by one of the exemplar's, before any block is laid.

A block beside the border shows several elements, and agrees with what is given of one or the other. So each of these is
looked for alone: what is known of it, and of the ground around that, is compared with every place of the exemplar, in
where its elements lie, and in colors but for a constant, as an element has a color of its own. What lies there of that
element, and a rim of ground, is laid.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from kwatra.elements import Lattice, Rows
from kwatra.exemplar import Exemplar
from kwatra.pieces.boxes import Box
from kwatra.pieces.choosing import Fit, StepCosts, totals
from kwatra.pieces.given import GivenCopies
from kwatra.pieces.seams import Array, Hidden, Mosaic, Parts, parts_of
from kwatra.pieces.sheet import Patch, Sheet

COLORS = 0.3
"""What it counts beside where elements lie that colors differ, each relative to its variance; by eye, on holes among
stones, coins and mosaics made in code, as what follows."""

COVERING, FITTING = 2.0, 0.025
"""What it counts beside those that an element would lie on what is known of others, in squares of an element's size; on
more than the second none is laid: where elements fill the plane what completes one seldom leaves room for the next, and
what is left between them are crumbs."""

AGREEING = 0.1
"""What disagrees more in form alone completes no element: blocks are laid there. Of coins and tiles that are cut by
holes or scratches most that are found disagree by less, of stones and mosaics cut by scratches most by more."""

AROUND, RIM = 8, 2
"""An element is compared with so many pixels of the ground around it, and laid with so many. Of stones, coins, mosaics,
letters and tiles around and in a hole .42 are cut where they are compared with 8, .43 with 3, with which one of which a
rim is seen may become too wide; but colors in scratches of 14 pixels are then off by 42 of 255 in place of 40."""

APART, PLACES, TRIED = 3, 3, 60
"""Places of one element further apart than so many pixels, so many of each, and so many of all that agree best: of
those it is counted what they would lie on. Bounds on time."""


class _Known(NamedTuple):
    """What is known of an element of some number: in a box of the sheet which pixels are its own, and are compared."""

    number: int
    box: tuple[slice, ...]
    own: Array
    compared: Array


class _Found(NamedTuple):
    """An element of the exemplar, by number, whose pixel x would lie at x + shift, and how little it agrees there."""

    number: int
    shift: tuple[int, ...]
    cost: float


def complete(
    sheet: Sheet[Mosaic],
    given: GivenCopies,
    exemplar: Exemplar,
    image: Array,
    hidden: Hidden,
    grain: Sequence[int] = (1, 1),
    repeats: Lattice | Rows | None = None,
) -> Array:
    """Complete elements on a sheet (H, W) that shows what is given alone; returns what was laid, boolean (H, W).

    image (C, *S): the colors of the exemplar's canvas. hidden: where seams are hidden on it, and where pixels are given
    that are none of it. grain: what offsets between output and canvas are multiples of. repeats: with which they are
    in step, if any. Memory is that of a few arrays of the canvas's size.
    """
    known, inside = ((one.owner >= 0).cpu().numpy() for one in (given.owned(exemplar), exemplar))
    return _Completion(sheet, given, parts_of(hidden, known), image, inside, grain, repeats).run()


class _Completion:
    """parts: the elements of the exemplar's canvas; inside (*S): what of it may be copied."""

    def __init__(
        self,
        sheet: Sheet[Mosaic],
        given: GivenCopies,
        parts: Parts,
        image: Array,
        inside: Array,
        grain: Sequence[int],
        repeats: Lattice | Rows | None,
    ) -> None:
        self.sheet, self.given, self.parts, self.inside = sheet, given, parts, inside
        self.grain, self.repeats = grain, repeats
        variances = np.array([parts.deep[inside].var(), image[:, inside].var(1).sum()])
        scales = np.sqrt(np.array([1.0, COLORS]) / np.where(variances > 0, variances, np.inf))
        self.planes = np.concatenate([parts.deep[None] * scales[0], image * scales[1]]).astype(np.float32)
        self.fit = Fit(self.planes)
        self.whole, self.boxes = parts.whole(inside), ndimage.find_objects(parts.number.clip(min=0))
        self.number, self.shown = given.shown(parts.number), given.shown(self.planes)
        self.beyond = ndimage.distance_transform_edt(given.where)
        self.laid = np.zeros(sheet.shape, bool)

    def run(self) -> Array:
        """Complete what is cut, the longest cuts first; returns what was laid, boolean (H, W)."""
        for known in self._cut():
            covering = {found: self._covering(known, found) for found in self._places(known)}
            fitting = [found for found, covered in covering.items() if covered <= FITTING]
            if fitting:
                self._lay(known, min(fitting, key=lambda found: found.cost + COVERING * covering[found]))
        return self.laid

    def _cut(self) -> Iterator[_Known]:
        """What is known of each element that the border cuts."""
        border = (self.beyond == 1) & (self.number > 0)
        numbers, lengths = np.unique(self.number[border], return_counts=True)
        for number in numbers[np.argsort(-lengths, kind="stable")].tolist():
            own = (self.number == number) & (self.beyond <= self.parts.size)
            compared = own | (_grown(own, AROUND) & self.given.where & (self.number == 0))
            (box,) = ndimage.find_objects(compared.astype(np.int8))
            if all(side.stop - side.start <= size for side, size in zip(box, self.inside.shape, strict=True)):
                yield _Known(number, box, own[box], compared[box])

    def _places(self, known: _Known) -> list[_Found]:
        """Where whole elements lie that agree best with what is known of one, a few places of each."""
        costs = self._disagreement(known)
        costs[~self._on_grain(known, costs.shape)] = np.inf
        deepest = np.where(known.own, self.shown[0][known.box], -np.inf)
        middle = np.unravel_index(int(deepest.argmax()), deepest.shape)
        number = self.parts.number[tuple(slice(at, at + n) for at, n in zip(middle, costs.shape, strict=True))]
        costs[~self.whole[number.clip(min=0)]] = np.inf
        if self.repeats is not None:
            costs += self._out_of_step(known, costs.shape)
        found, numbers = list[_Found](), np.unique(number[np.isfinite(costs)])
        for _ in range(PLACES if numbers.size else 0):
            for at in ndimage.minimum_position(costs, number, numbers):
                if np.isfinite(costs[at]) and self._unlike(known, at) <= AGREEING:
                    shift = tuple(int(side.start - a) for side, a in zip(known.box, at, strict=True))
                    found.append(_Found(int(number[at]), shift, float(costs[at])))
                costs[tuple(slice(max(a - APART, 0), a + APART + 1) for a in at)] = np.inf
        return sorted(found, key=lambda one: one.cost)[:TRIED]

    def _unlike(self, known: _Known, at: tuple[int, ...]) -> float:
        """How little what is known of an element, and what lies at a place, agree in form: in where elements lie."""
        there = tuple(slice(a, a + n) for a, n in zip(at, known.own.shape, strict=True))
        apart = self.planes[0][there] - self.shown[0][known.box]
        return float(np.square(apart[known.compared]).mean())

    def _disagreement(self, known: _Known) -> Array:
        """How little each place of the canvas agrees with what is known of an element, infinite on its holes."""
        own, compared = known.own.astype(np.float32), known.compared.astype(np.float32)
        content, count = self.shown[(slice(None), *known.box)], own.sum()
        weights = np.stack([compared / compared.sum(), *[own / count] * (len(content) - 1)])
        costs = self.fit.inside(content, weights)
        for plane, here in zip(self.planes[1:], content[1:], strict=True):
            costs -= np.square(totals(own, plane) - (own * here).sum()) / count**2
        costs[totals(compared, (~self.inside).astype(np.float32)) > 0.5] = np.inf
        return costs

    def _on_grain(self, known: _Known, shape: tuple[int, ...]) -> Array:
        """Whether what is known would lie at a multiple of the grain from each place, boolean (*shape)."""
        lines = zip(known.box, shape, self.grain, strict=True)
        rows, columns = ((side.start - np.arange(n)) % g == 0 for side, n, g in lines)
        on: Array = rows[:, None] & columns
        return on

    def _out_of_step(self, known: _Known, shape: tuple[int, ...]) -> Array:
        """What it costs that an element at each place (*shape) is out of step with what is known."""
        assert self.repeats is not None
        at = tuple(side.start + line[0] for side, line in zip(known.box, np.nonzero(known.own), strict=True))
        there = self.sheet.sources.coordinates(self.sheet.places[at][None])[1][:, 0]
        first = [side.start - (a - int(b)) for side, a, b in zip(known.box, at, there, strict=True)]
        return StepCosts(self.repeats, shape, (1,) * len(shape)).at(first)

    def _covering(self, known: _Known, found: _Found) -> float:
        """On how much of what is known of others a found element would lie, in squares of an element's size."""
        box = self.boxes[found.number - 1]
        first = [side.start + by for side, by in zip(box, found.shift, strict=True)]
        at = tuple(self._on_sheet(np.argwhere(self.parts.number[box] == found.number) + np.array(first)).T)
        others = self.sheet.filled_at(at) & (self.number[at] != known.number)
        return np.count_nonzero(others) / self.parts.size**2

    def _lay(self, known: _Known, found: _Found) -> None:
        """Lay a found element, and ground around it, as far as it hangs together with what is known of it."""
        element = self.parts.number == found.number
        rim = _grown(element, RIM) & self.inside & (self.parts.number == 0)
        free, own = ~self.sheet.filled, self.number == known.number
        joined, _ = ndimage.label((self._moved(element | rim, found.shift) & free) | own)
        here = np.isin(joined, np.unique(joined[own])) & free
        shift = np.array(found.shift)[:, None]
        self.sheet.label[here] = len(self.sheet.patches)
        self.sheet.patches.append(Patch(0, found.shift, Box((0,) * here.ndim, self.sheet.shape)))
        self.sheet.places[here] = self.sheet.sources.places_of(list(np.argwhere(here).T - shift))
        self.sheet.fixed |= here
        self.laid |= here

    def _moved(self, there: Array, shift: tuple[int, ...]) -> Array:
        """Of some pixels of the canvas (*S) where they would lie on the sheet, boolean (H, W)."""
        here = np.zeros(self.sheet.shape, bool)
        here[tuple(self._on_sheet(np.argwhere(there) + np.array(shift)).T)] = True
        return here

    def _on_sheet(self, at: Array) -> Array:
        """Those of pixels (n, 2) that lie on the sheet."""
        on: Array = at[((at >= 0) & (at < self.sheet.shape)).all(1)]
        return on


def _grown(pixels: Array, steps: int) -> Array:
    grown: Array = ndimage.binary_dilation(pixels, iterations=steps)
    return grown
