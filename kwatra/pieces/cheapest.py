"""Of several patches of a mosaic, tried in one window, the one to lay."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from kwatra.cut import MOST, solved_at_once
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.sheet import Cut, Patch, Sheet, Window
from kwatra.pieces.stock import Array

Offer = tuple[Patch, float, float, Array | None]
"""A patch, its cost and rate, and what pixels cost more that take it."""


def cheapest_cut(
    sheet: Sheet[Mosaic],
    window: Window,
    patches: Sequence[Patch],
    costs: Array,
    rates: Array,
    least: float,
    *,
    must: bool = False,
    taking: Sequence[Array] = (),
) -> Cut | None:
    """Of patches of a mosaic's first source, in a window of a sheet, the one that costs least; None if all are dearer.

    A patch costs its own of the costs (n,) and, times its rate (n,), the price of its cut; below `least`. Of equals it
    is the first. must: whether all of a patch is taken. taking: as for `Sheet.cut`, of each patch.
    """
    if not solved_at_once(window.laid):
        more: Sequence[Array | None] = taking or [None] * len(patches)
        offers = zip(patches, costs.tolist(), rates.tolist(), more, strict=True)
        return _one_by_one(sheet, window, offers, least, must)
    from kwatra.pieces.tries import Ground, Tries, cheapest_of

    origin, extra = np.array(window.box.start), np.zeros((len(taking), window.kept.size), np.int64)
    for row, patch, priced in zip(extra, patches, taking, strict=False):
        row.reshape(window.kept.shape)[window.part(patch.box)] = priced
    corners = [patch.shift for patch in patches], [p.box.start for p in patches], [p.box.stop for p in patches]
    shifts, starts, stops = (np.array(corner) - origin for corner in corners)
    depth, mosaic = sheet.cost.depth, sheet.sources
    hidden = (1.0, 0.0) if depth is None else (depth.hidden, depth.least)
    laid = window.kept, window.laid, window.fixed, window.places, window.remembered, window.total
    ground = Ground(*laid, mosaic.planes, mosaic.shapes[0], mosaic.strides, sheet.cost.deep, *hidden)
    found = cheapest_of(Tries(shifts, starts, stops, costs, rates, must, extra), ground, least)
    if found is None:
        return None
    return Cut(patches[found.number], window.at, found.take, found.places, found.seams, found.change, found.price)


def _one_by_one(sheet: Sheet[Mosaic], window: Window, offers: Iterable[Offer], least: float, must: bool) -> Cut | None:
    """The same where cuts may be too large to be solved at once."""
    best = None
    for patch, cost, rate, taking in offers:
        most = MOST if least == math.inf else math.ceil((least - cost) / rate)
        whole = np.ones(patch.box.extent, bool) if must else None
        cut = sheet.cut_below(most, patch, must=whole, taking=taking, window=window)
        if cut is not None and cost + rate * cut.price < least:
            best, least = cut, cost + rate * cut.price
    return best
