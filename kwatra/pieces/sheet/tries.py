"""Several patches tried on one window, and the one that is laid at the least cost, in one compiled call.

It holds no lock of the interpreter's, so threads can share the patches, or lay on several windows side by side. Pixels
are seen as (before, rows, columns), whatever their axes.

This module is compiled by numba when first used, so it is imported where patches are tried.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from kwatra.base import shared, threads_shared
from kwatra.base.compiled import jitted
from kwatra.cut.choices import FREE, MOST, TAKE
from kwatra.pieces.loops import copy_into, patch_sides
from kwatra.pieces.seams import Array, Prices
from kwatra.pieces.seams.matches import cut_places
from kwatra.pieces.sheet.pixels import of_pairs, of_pixels, places_before
from kwatra.pieces.sheet.window import Pixels

Item = TypeVar("Item")


class Tries(NamedTuple):
    """Patches (n,) of a mosaic's first source, tried on windows (b,), those of one after those of the one before.

    Each is all that a box shows of the source. firsts (b + 1,): which is the first on each window, and how many there
    are. shifts (n, AXES): by how much the source is shifted, counted from the window's first pixel; bounds (b, 3,
    AXES): its size, where the box begins, and where it has ended, counted as well. costs (n,): what each costs beside
    its price; rates (n,): what its price counts; least: what they have to cost less than. must: whether all of a patch
    is taken. taking (p,): what each pixel of a window costs more when it takes a patch, as in `Sheet.cut`, of one patch
    after the other; (0,) for nothing.
    """

    firsts: Array
    shifts: Array
    bounds: Array
    costs: Array
    rates: Array
    least: float
    must: bool
    taking: Array


class Ground(NamedTuple):
    """What patches are laid on, and of: `pixels` of windows, colors by place (C, N) and what places mean.

    owned (N,): which places are shown at all, of none where all are. strides (AXES,): from a place to the next. prices:
    what seams cost there.
    """

    pixels: Pixels
    planes: Array
    owned: Array
    strides: Array
    prices: Prices


class Offered(NamedTuple):
    """What is tried, on what, and on which of the windows (b,)."""

    tries: Tries
    ground: Ground
    tried: Array


class Found(NamedTuple):
    """On each window the number, among those tried there, of the patch that costs least, -1 for none, and its cost.

    The rest is as in `Cuts`, and means nothing where there is none.
    """

    number: Array
    cost: Array
    take: Array
    places: Array
    seams: Array
    change: Array
    price: Array


def cheapest_of(groups: Sequence[Item], offered: Callable[[Item], Offered]) -> list[Found]:
    """On each window the patch whose cost, and price times rate, come to least; none if none is below a bound.

    Of equals it is the first. What is offered of a group is told when a thread begins with it, of one alone before.
    Threads share the groups; who finds all begun helps with the last windows, patch by patch, knowing what has been
    found: a cut that costs more need not be solved. They come in the order of groups.
    """
    begun: list[_Contest | None] = [_Contest(offered(groups[0]))] if len(groups) == 1 else [None for _ in groups]

    def begin(number: int) -> None:
        contest = begun[number] or _Contest(offered(groups[number]))
        begun[number] = contest
        contest.join()

    def help_with(number: int) -> None:
        contest = begun[number]
        if contest is not None:
            contest.join(backwards=True)

    order, helpers = range(len(begun)), threads_shared() - 1
    work = [*(partial(begin, n) for n in order), *(partial(help_with, n) for n in [*reversed(order)] * helpers)]
    shared(lambda each: each(), work)
    return [contest.best for contest in begun if contest is not None]


class _Contest:
    """Patches that are tried on windows, and the best of them that any thread has found."""

    def __init__(self, offered: Offered) -> None:
        self._tries, self._ground, tried = offered
        self._counts = np.diff(self._tries.firsts)
        self._lowest, self._following = np.full(len(tried), self._tries.least), np.where(tried, 0, self._counts)
        self._found = list[Found]()

    def join(self, backwards: bool = False) -> None:
        """Try patches until all have been begun with; backwards: of the last window first."""
        if self._found and not (self._following < self._counts).any():
            return
        pixels, windows = self._ground.pixels, len(self._counts)
        places, seams = np.empty_like(pixels.places), np.empty_like(pixels.remembered)
        of_each = np.full(windows, -1), np.empty(windows), np.empty(pixels.kept.size, np.bool_), places, seams
        found = Found(*of_each, np.zeros(windows, np.int64), np.zeros(windows, np.int64))
        _try_each(self._tries, self._ground, self._lowest, self._following, backwards, found)
        self._found.append(found)

    @property
    def best(self) -> Found:
        """The cheapest of what was found, of equals the first."""
        first, *others = self._found
        for other in others:
            _merge(self._ground.pixels.extents, other, first)
        return first


@jitted
def _try_each(tries: Any, ground: Any, lowest: Any, following: Any, backwards: Any, found: Any) -> None:
    """Set what is found on each window of the patches that no other thread has begun with; found: arrays for it.

    lowest, following (b,): the least that any thread has found so far, and the patch to be tried next.
    """
    seen, windows, priced = ground.pixels, len(following), np.zeros(len(following), np.int64)
    pixels, pairs = places_before(seen.extents)
    for n in range(windows - 1):
        priced[n + 1] = priced[n] + (tries.firsts[n + 1] - tries.firsts[n]) * seen.extents[n].prod()
    for step in range(windows):
        n = windows - 1 - step if backwards else step
        extent, first, low, high = seen.extents[n], pixels[n], tries.firsts[n], tries.firsts[n + 1]
        last, taking = first + extent.prod(), tries.taking[:0].reshape((0, 0))
        if len(tries.taking) > 0:
            stop = priced[n] + (high - low) * (last - first)
            taking = tries.taking[priced[n] : stop].reshape((high - low, last - first))
        number, found.cost[n], found.change[n], found.price[n] = _try_every(
            of_pixels(seen.kept, first, extent), of_pixels(seen.laid, first, extent),
            of_pixels(seen.fixed, first, extent), of_pixels(seen.places, first, extent),
            _along(of_pairs(seen.remembered, pairs[n], extent)), seen.totals[n], ground.planes, ground.owned,
            ground.strides, ground.prices, tries.shifts[low:high], tries.bounds[n], tries.costs[low:high],
            tries.rates[low:high], tries.must, taking, tries.least, lowest[n : n + 1], following[n : n + 1],
            found.take[first:last], found.places[first:last], _along(of_pairs(found.seams, pairs[n], extent)),
        )  # fmt: skip
        found.number[n] = number


@jitted
def _try_every(
    kept: Any, laid: Any, fixed: Any, old: Any, a: Any, total: Any, planes: Any, owned: Any, strides: Any, prices: Any,
    shifts: Any, bounds: Any, costs: Any, rates: Any, must: Any, taking: Any, least: Any, lowest: Any, following: Any,
    take: Any, places: Any, left: Any,
) -> Any:  # fmt: skip
    """The number of the cheapest try, -1 for none, what it costs, its change and price.

    Sets what it takes and shows, and along each axis the seams that are left with it. Threads that ask for the next at
    once may try the same, but leave none out: a number is written only where the one before it was taken. Which tries
    are given up depends on what other threads have found by then, but none that is as cheap is: `most` is rounded up.
    """
    count, best, best_change, best_price = kept.size, -1, 0, 0
    choice, new, taken = np.empty(kept.shape, np.int8), np.empty(old.shape, old.dtype), np.empty(count, np.bool_)
    weight = np.zeros(count, np.int64)
    shown_old, shown_new, may, without = old.ravel(), new.ravel(), choice.ravel(), kept.ravel()
    b, c, tried = _like(a), _like(a), _like(a)
    starts, stops = patch_sides(shifts, bounds)
    while following[0] < len(costs):
        k = following[0]
        following[0] = k + 1
        if costs[k] == np.inf:
            continue
        most = MOST if lowest[0] == np.inf else math.ceil((lowest[0] - costs[k]) / rates[k])
        if len(taking) == 0 and -total > most:  # were no seam left
            continue
        _lay_out(kept, laid, fixed, starts[k], stops[k], must, choice)
        _find_places(bounds[0], strides, shifts[k], starts[k], stops[k], new)
        if len(owned) > 0:
            for i in range(count):
                may[i] = may[i] if owned[shown_new[i]] else without[i]
        for i in range(count):
            weight[i] = taking[k, i] if len(taking) > 0 else 0
        if not cut_places(planes, strides, shown_old, shown_new, prices, may, weight, a, b, c, most, taken, tried):
            continue
        change = -total
        for axis in range(len(a)):
            change += tried[axis].sum()
        price = change
        if len(taking) > 0:
            for i in range(count):
                price += taking[k, i] if taken[i] and may[i] == FREE else 0
        cost = costs[k] + rates[k] * price
        if cost < least:
            least, best, best_change, best_price = cost, k, change, price
            lowest[0] = min(lowest[0], cost)
            copy_into(taken, take)
            copy_into(shown_new, places)
            for axis in range(len(a)):
                copy_into(tried[axis].ravel(), left[axis].ravel())
    return best, least, best_change, best_price


@jitted
def _merge(extents: Any, other: Any, best: Any) -> None:
    """Take over what was found by another thread on windows of extents (b, 3) that is better, or as good and first."""
    pixels, pairs = places_before(extents)
    for n in range(len(extents)):
        none = best.number[n] < 0
        sooner = other.cost[n] == best.cost[n] and other.number[n] < best.number[n]
        if other.number[n] >= 0 and (none or other.cost[n] < best.cost[n] or sooner):
            best.number[n], best.cost[n] = other.number[n], other.cost[n]
            best.change[n], best.price[n] = other.change[n], other.price[n]
            extent, first = extents[n], pixels[n]
            part = slice(first, first + extent.prod())
            best.take[part], best.places[part] = other.take[part], other.places[part]
            stop = pairs[n + 1] if n + 1 < len(pairs) else len(best.seams)
            best.seams[pairs[n] : stop] = other.seams[pairs[n] : stop]


@jitted
def _along(pairs: Any) -> Any:
    """What pairs of pixels have along each of three axes (`of_pairs`) as (before, along, behind) that axis."""
    one, two, three = pairs
    return (
        one.reshape((1, one.shape[0], one.shape[1] * one.shape[2])),
        two,
        three.reshape((three.shape[0] * three.shape[1], three.shape[2], 1)),
    )


@jitted
def _like(costs: Any) -> Any:
    """Room for as many costs along each of three axes."""
    first, second, third = costs
    return np.empty(first.shape, np.int32), np.empty(second.shape, np.int32), np.empty(third.shape, np.int32)


@jitted
def _lay_out(kept: Any, laid: Any, fixed: Any, start: Any, stop: Any, must: Any, choice: Any) -> None:
    """What may happen to pixels where a patch is laid from start to before stop."""
    copy_into(kept.ravel(), choice.ravel())
    for i in range(start[0], stop[0]):
        for j in range(start[1], stop[1]):
            for k in range(start[2], stop[2]):
                choice[i, j, k] = TAKE if must and not fixed[i, j, k] else laid[i, j, k]


@jitted
def _find_places(sizes: Any, strides: Any, shift: Any, start: Any, stop: Any, places: Any) -> None:
    """The places a window shows of a shifted source, which goes on beyond the patch by one pixel, and by its rim."""
    for i in range(places.shape[0]):
        plane = _line(i, start[0], stop[0], shift[0], sizes[0]) * strides[0]
        for j in range(places.shape[1]):
            row = plane + _line(j, start[1], stop[1], shift[1], sizes[1]) * strides[1]
            for k in range(places.shape[2]):
                places[i, j, k] = row + _line(k, start[2], stop[2], shift[2], sizes[2]) * strides[2]


@jitted
def _line(at: Any, start: Any, stop: Any, shift: Any, size: Any) -> Any:
    """How far along an axis of the mosaic a pixel's place lies."""
    return min(max(min(max(at, start - 1), stop) - shift, -1), size) + 1
