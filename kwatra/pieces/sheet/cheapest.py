"""Of several patches of a mosaic, tried in one window, the one to lay."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from kwatra.base import shared
from kwatra.cut import MOST, solved_at_once
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array, Mosaic
from kwatra.pieces.sheet.sheet import Cut, Patch, Sheet
from kwatra.pieces.sheet.window import Window

if TYPE_CHECKING:
    from kwatra.pieces.sheet.tries import Found, Ground, Tries


Item = TypeVar("Item")

ALL = np.empty(0, bool)
"""Places that are shown at all, where none is told."""


class Offer(NamedTuple):
    """Patches of a mosaic's first source, each all that it shows of a box in a window of a sheet.

    shifts (n, axes): by how much the source is shifted (`Patch`). A patch costs its own of the costs (n,) and, times
    its rate (n,), the price of its cut; `least`: what it has to cost less than. must: whether all of a patch is taken.
    taking: as for `Sheet.cut`, of each patch; () for nothing.
    """

    window: Window
    box: Box
    shifts: Array
    costs: Array
    rates: Array
    least: float
    must: bool = False
    taking: Sequence[Array] = ()


def patch_of(box: Box, shift: Sequence[int], sheet: Sheet[Mosaic]) -> Patch:
    """All that a box of a sheet shows of its mosaic's first source, shifted."""
    return Patch(0, tuple(shift), box.within(Box(tuple(shift), sheet.sources.shapes[0])))


def cheapest_cuts(sheet: Sheet[Mosaic], offers: Sequence[Offer], owned: Array = ALL) -> list[Cut | None]:
    """Of each offer the patch that costs least, of equals the first; None if none costs less than it has to.

    owned: by place of the mosaic, what patches show at all; where they lie on holes nothing changes. Threads share the
    offers.
    """
    return cheapest_as_offered(sheet, [offers], list, owned)


def cheapest_as_offered(
    sheet: Sheet[Mosaic], groups: Sequence[Item], offers: Callable[[Item], Sequence[Offer]], owned: Array = ALL
) -> list[Cut | None]:
    """The same of what is offered of groups, one after the other; `offers` is asked by the thread that takes a group.

    So none waits for what others are offered before it begins with cuts.
    """
    from kwatra.pieces.sheet.tries import Offered, cheapest_of

    made: dict[int, list[tuple[Offer, bool]]] = {}  # of each group, and whether they are small: solved at once

    def tried(number: int) -> list[Offered]:
        made[number] = [(offer, solved_at_once(offer.window.laid)) for offer in offers(groups[number])]
        return [_tried(sheet, offer, owned) for offer, small in made[number] if small]

    found = iter(cheapest_of(range(len(groups)), tried))
    every = [each for number in range(len(groups)) for each in made[number]]
    cuts = iter(shared(partial(_one_by_one, sheet, owned), [offer for offer, small in every if not small]))
    return [_cut_of(sheet, offer, next(found)) if small else next(cuts) for offer, small in every]


def _cut_of(sheet: Sheet[Mosaic], offer: Offer, best: "Found | None") -> Cut | None:
    """What was found of an offer as a cut of the sheet."""
    if best is None:
        return None
    taken = best.take, best.places, best.seams, best.change, best.price
    return Cut(patch_of(offer.box, offer.shifts[best.number].tolist(), sheet), offer.window, *taken)


def _tried(sheet: Sheet[Mosaic], offer: Offer, owned: Array) -> tuple["Tries", "Ground", float]:
    """An offer as arrays, counted from its window's first pixel."""
    from kwatra.pieces.sheet.tries import Ground, Tries

    window, mosaic = offer.window, sheet.sources
    extra = np.zeros((len(offer.taking), window.kept.size), np.int64)
    shifts = offer.shifts - np.array(window.box.start)
    for row, shift, priced in zip(extra, offer.shifts.tolist(), offer.taking, strict=False):
        row.reshape(window.kept.shape)[window.box.part(patch_of(offer.box, shift, sheet).box)] = priced
    laid = window.kept, window.laid, window.fixed, window.places, window.remembered, window.total
    ground = Ground(*laid, mosaic.planes, owned, mosaic.strides, sheet.cost.prices)
    bounds = window.bounds(offer.box, mosaic.shapes[0])
    return Tries(shifts, bounds, offer.costs, offer.rates, offer.must, extra), ground, offer.least


def _one_by_one(sheet: Sheet[Mosaic], owned: Array, offer: Offer) -> Cut | None:
    """The same where cuts may be too large to be solved at once."""
    best, least = None, offer.least
    more: Sequence[Array | None] = offer.taking or [None] * len(offer.shifts)
    each = offer.shifts.tolist(), offer.costs.tolist(), offer.rates.tolist(), more
    for shift, cost, rate, taking in zip(*each, strict=True):
        patch = patch_of(offer.box, shift, sheet)
        most = MOST if least == math.inf else math.ceil((least - cost) / rate)
        whole = np.ones(patch.box.extent, bool) if offer.must else None
        holes = ~owned[sheet.patch_places(patch, patch.box)] if len(owned) else None
        cut = sheet.cut_below(most, patch, must=whole, must_not=holes, taking=taking, window=offer.window)
        if cut is not None and cost + rate * cut.price < least:
            best, least = cut, cost + rate * cut.price
    return best
