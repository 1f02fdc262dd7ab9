"""Of several patches of a mosaic, tried in one window, the one to lay."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from kwatra.base import shared
from kwatra.base.spans import in_volume
from kwatra.cut import MOST, solved_at_once
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Array, Mosaic
from kwatra.pieces.sheet.cuts import Cut, Cuts, Patch
from kwatra.pieces.sheet.sheet import Sheet
from kwatra.pieces.sheet.window import Windows

if TYPE_CHECKING:
    from kwatra.pieces.sheet.tries import Found, Offered


Item = TypeVar("Item")

ALL = np.empty(0, bool)
"""Places that are shown at all, where none is told."""


class Offer(NamedTuple):
    """Patches of a mosaic's first source, each all that it shows of a box in a window of a sheet; of several boxes.

    firsts (b + 1,): which patch is the first of each box, and how many there are. shifts (n, axes): by how much the
    source is shifted (`Patch`). A patch costs its own of the costs (n,) and, times its rate (n,), the price of its cut;
    `least`: what it has to cost less than. must: whether all of a patch is taken. taking: as for `Sheet.cut`, of each
    patch; () for nothing.
    """

    windows: Windows
    boxes: Sequence[Box]
    firsts: Array
    shifts: Array
    costs: Array
    rates: Array
    least: float
    must: bool = False
    taking: Sequence[Array] = ()


def patch_of(box: Box, shift: Sequence[int], sheet: Sheet[Mosaic]) -> Patch:
    """All that a box of a sheet shows of its mosaic's first source, shifted."""
    return Patch(0, tuple(shift), box.within(Box(tuple(shift), sheet.sources.shapes[0])))


def cheapest_cuts(sheet: Sheet[Mosaic], offer: Offer, owned: Array = ALL) -> Cuts:
    """In each box the patch that costs least, of equals the first; none if none costs less than it has to.

    owned: by place of the mosaic, what patches show at all; where they lie on holes nothing changes. Threads share what
    is tried.
    """
    return cheapest_as_offered(sheet, [offer], lambda group: group, owned)[0]


def cheapest_as_offered(
    sheet: Sheet[Mosaic], groups: Sequence[Item], offers: Callable[[Item], Offer], owned: Array = ALL
) -> list[Cuts]:
    """The same of what is offered of groups, one after the other; `offers` is asked by the thread that takes a group.

    So none waits for what others are offered before it begins with cuts.
    """
    from kwatra.pieces.sheet.tries import cheapest_of

    made: dict[int, tuple[Offer, Array]] = {}  # of each group, and on which windows cuts are small: solved at once

    def offered(number: int) -> "Offered":
        offer = offers(groups[number])
        laid = (offer.windows.of_pixels(offer.windows.pixels.laid, n) for n in range(len(offer.windows)))
        made[number] = offer, np.array([solved_at_once(one) for one in laid])
        return _offered(sheet, *made[number], owned)

    found = cheapest_of(range(len(groups)), offered)
    cuts = [_cuts_of(sheet, made[number][0], best) for number, best in enumerate(found)]
    large = [(number, n) for number in range(len(groups)) for n in np.flatnonzero(~made[number][1]).tolist()]
    others = shared(lambda which: _one_by_one(sheet, made[which[0]][0], which[1], owned), large)
    for (number, n), cut in zip(large, others, strict=True):
        cuts[number].put(n, cut)
    return cuts


def _offered(sheet: Sheet[Mosaic], offer: Offer, small: Array, owned: Array) -> "Offered":
    """An offer as arrays, counted from its windows' first pixels; small (b,): on which windows it is tried."""
    from kwatra.pieces.sheet.tries import Ground, Offered, Tries

    windows, mosaic = offer.windows, sheet.sources
    shifts, bounds = windows.counted(offer.boxes, offer.firsts, offer.shifts, mosaic.shapes[0])
    taking = _taking(sheet, offer) if offer.taking else np.empty(0, np.int64)
    tries = Tries(offer.firsts, shifts, bounds, offer.costs, offer.rates, offer.least, offer.must, taking)
    ground = Ground(windows.pixels, mosaic.planes, owned, in_volume(mosaic.strides, 0), sheet.cost.prices)
    return Offered(tries, ground, small)


def _taking(sheet: Sheet[Mosaic], offer: Offer) -> Array:
    """What each pixel of windows costs more when it takes a patch, of one patch after the other."""
    every, numbers = list[Array](), np.repeat(np.arange(len(offer.boxes)), np.diff(offer.firsts)).tolist()
    for number, shift, priced in zip(numbers, offer.shifts.tolist(), offer.taking, strict=True):
        window, box = offer.windows.boxes[number], offer.boxes[number]
        extra = np.zeros(window.extent, np.int64)
        extra[window.part(patch_of(box, shift, sheet).box)] = priced
        every.append(extra.ravel())
    return np.concatenate(every)


def _cuts_of(sheet: Sheet[Mosaic], offer: Offer, best: "Found") -> Cuts:
    """What was found of an offer as cuts of the sheet."""
    chosen = best.number.tolist()
    shifts = offer.shifts[offer.firsts[:-1] + best.number].tolist()  # of what is none, any
    each = zip(offer.boxes, shifts, chosen, strict=True)
    patches = [None if number < 0 else patch_of(box, shift, sheet) for box, shift, number in each]
    return Cuts(offer.windows, patches, best.take, best.places, best.seams, best.change, best.price)


def _one_by_one(sheet: Sheet[Mosaic], offer: Offer, number: int, owned: Array) -> Cut | None:
    """That of one box where cuts may be too large to be solved at once."""
    best, least, box, window = None, offer.least, offer.boxes[number], offer.windows[number]
    for n in range(offer.firsts[number], offer.firsts[number + 1]):
        patch, cost, rate = patch_of(box, offer.shifts[n].tolist(), sheet), float(offer.costs[n]), float(offer.rates[n])
        most = MOST if least == math.inf else math.ceil((least - cost) / rate)
        whole = np.ones(patch.box.extent, bool) if offer.must else None
        holes = ~owned[sheet.patch_places(patch, patch.box)] if len(owned) else None
        taking = offer.taking[n] if offer.taking else None
        cut = sheet.cut_below(most, patch, must=whole, must_not=holes, taking=taking, window=window)
        if cut is not None and cost + rate * cut.price < least:
            best, least = cut, cost + rate * cut.price
    return best
